//! Fewer, larger barriers: each may stand anywhere between the uses it orders, and each call of
//! `vkCmdPipelineBarrier2` drains the device. The last place that still serves the barrier due first serves every
//! other one whose uses lie around it: as few calls as can be (points that stab intervals).

use super::barriers::Pending;
use super::history::{At, Schedule};
use super::queues::Crossing;

/// Moves barriers up to where one stands anyway. `pending` comes, and stays, sorted by place. `takers`: steps that wait
/// for graphics to hand over what was imported.
pub(super) fn gather(pending: &mut [Pending], schedule: &Schedule, crossings: &[Crossing], takers: &[usize]) {
    let waits = waits(schedule, crossings.iter().map(|crossing| crossing.to).chain(takers.iter().copied()));
    // By queue: where some barrier stands. What only orders comes last: others may order as much.
    let mut places: [Vec<At>; 3] = Default::default();
    for orders in [false, true] {
        for barrier in pending.iter_mut().filter(|barrier| !barrier.release && barrier.only_orders() == orders) {
            let Some(step) = barrier.at.index() else { continue };
            let queue = schedule.queues[step];
            let places = &mut places[queue as usize];
            let here = |before: Option<usize>| before.is_none_or(|step| schedule.queues[step] == queue);
            let before = barrier.behind;
            let place = places.partition_point(|place| *place <= barrier.at);
            match place.checked_sub(1).map(|last| places[last]) {
                Some(place) if place > before && place >= waits[step] && here(before.index()) => barrier.at = place,
                Some(last) if last == barrier.at => {}
                _ => places.insert(place, barrier.at),
            }
        }
    }
    pending.sort_by_key(|barrier| (barrier.at, barrier.release, barrier.cell));
}

/// By step: the last step up to it that its queue waits for another one before. What a semaphore orders comes behind.
fn waits(schedule: &Schedule, waiting: impl Iterator<Item = usize>) -> Vec<At> {
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
