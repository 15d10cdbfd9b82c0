//! Fewer, larger barriers: each may stand anywhere between the uses it orders, and each call of
//! `vkCmdPipelineBarrier2` drains the device. The last place that still serves the barrier due first serves every
//! other one whose uses lie around it: as few calls as can be (points that stab intervals).

use super::barriers::AllPending;
use super::history::{At, Schedule};
use super::queues::Crossing;

/// Moves barriers up to where one stands anyway. `takers`: steps that wait for graphics to hand over what was imported.
pub(super) fn gather(pending: &mut AllPending, schedule: &Schedule, crossings: &[Crossing], takers: &[usize]) {
    let waits = waits(schedule, crossings.iter().map(|crossing| crossing.to).chain(takers.iter().copied()));
    // By queue: where some barrier stands, ascending. What only orders comes last: others may order as much.
    let mut places: [Vec<At>; 3] = Default::default();
    let (mut moved, mut some_order) = (false, false);
    for orders in [false, true] {
        if orders && !some_order {
            break;
        }
        // By queue: how many of the places are passed, and the last one, which may be new.
        let (mut passed, mut last) = ([0; 3], [None; 3]);
        for &index in &pending.order {
            let barrier = &mut pending.list[index as usize];
            let only_orders = barrier.only_orders();
            some_order |= only_orders;
            if barrier.release || only_orders != orders {
                continue;
            }
            let Some(step) = barrier.at.index() else { continue };
            let queue = schedule.queues[step];
            let (places, passed, last) =
                (&mut places[queue as usize], &mut passed[queue as usize], &mut last[queue as usize]);
            while let Some(place) = places.get(*passed).filter(|place| **place <= barrier.at) {
                *last = (*last).max(Some(*place));
                *passed += 1;
            }
            let here = |before: Option<usize>| before.is_none_or(|step| schedule.queues[step] == queue);
            match *last {
                Some(place)
                    if place > barrier.behind
                        && waits.get(step).is_none_or(|wait| place >= *wait)
                        && here(barrier.behind.index()) =>
                {
                    moved |= barrier.at != place;
                    barrier.at = place;
                }
                Some(place) if place == barrier.at => {}
                _ => {
                    *last = Some(barrier.at);
                    if !orders {
                        places.reserve(if places.is_empty() { schedule.nodes.len() } else { 0 });
                        places.push(barrier.at);
                    }
                }
            }
        }
    }
    if moved {
        pending.sort(schedule.nodes.len());
    }
}

/// By step: the last step up to it that its queue waits for another one before. What a semaphore orders comes behind.
/// Nothing where no queue waits.
fn waits(schedule: &Schedule, waiting: impl Iterator<Item = usize>) -> Vec<At> {
    let mut waiting = waiting.peekable();
    if waiting.peek().is_none() {
        return Vec::new();
    }
    let mut waits = vec![At::START; schedule.queues.len()];
    for step in waiting {
        if let Some(wait) = waits.get_mut(step) {
            *wait = At::step(step);
        }
    }
    let mut last = [At::START; 3];
    for (wait, &queue) in waits.iter_mut().zip(&schedule.queues) {
        let last = &mut last[queue as usize];
        *last = (*last).max(*wait);
        *wait = *last;
    }
    waits
}
