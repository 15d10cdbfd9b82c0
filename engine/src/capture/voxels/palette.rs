//! Few colours for many (Heckbert 1982, "Color Image Quantization for Frame Buffer Display", median cut): a box of colours
//! is cut in two at the median of its widest channel, the one that spreads most voxels widest first.

use std::collections::BTreeMap;

use rustc_hash::FxHashMap;

/// sRGB, 8 bits a channel.
pub(super) type Color = [u8; 3];

/// A colour, and how often it comes.
type Counted = (Color, u64);

/// At most `most` colours, and which of them each of these becomes. So many or fewer stay as they are.
pub(super) fn palette(colors: impl Iterator<Item = Color>, most: usize) -> (Vec<Color>, FxHashMap<Color, usize>) {
    let mut counts: BTreeMap<Color, u64> = BTreeMap::new();
    colors.for_each(|color| *counts.entry(color).or_default() += 1);
    let mut boxes: Vec<Vec<Counted>> = vec![counts.into_iter().collect()];
    while boxes.len() < most {
        let spreads = boxes.iter().map(|colors| spread(colors)).enumerate();
        // Of equal ones the first.
        let Some((index, (by, channel))) = spreads.max_by_key(|&(index, (by, _))| (by, usize::MAX - index)) else {
            break;
        };
        if by == 0 {
            break;
        }
        let behind = cut(&mut boxes[index], channel);
        boxes.push(behind);
    }
    let boxes: Vec<_> = boxes.into_iter().filter(|colors| !colors.is_empty()).collect();
    let places = boxes.iter().enumerate().flat_map(|(index, colors)| colors.iter().map(move |&(c, _)| (c, index)));
    (boxes.iter().map(|colors| mean(colors)).collect(), places.collect())
}

/// How far colours spread, times how many there are; and in which channel.
fn spread(colors: &[Counted]) -> (u64, usize) {
    let width = |channel: usize| {
        let values = colors.iter().map(|(color, _)| color[channel]);
        u64::from(values.clone().max().unwrap_or(0) - values.min().unwrap_or(0))
    };
    let count: u64 = colors.iter().map(|&(_, count)| count).sum();
    let widest = (0..3).max_by_key(|&channel| (width(channel), 2 - channel)).unwrap_or(0);
    (width(widest) * count, widest)
}

/// Takes off what lies behind the median of a channel, of which there are at least two values.
fn cut(colors: &mut Vec<Counted>, channel: usize) -> Vec<Counted> {
    colors.sort_by_key(|&(color, _)| (color[channel], color));
    let half = colors.iter().map(|&(_, count)| count).sum::<u64>() / 2;
    let mut before = 0;
    let median = colors.partition_point(|&(_, count)| {
        before += count;
        before <= half
    });
    // Colours of one value stay together.
    let value = |at: usize| colors.get(at).map(|(color, _)| color[channel]);
    let at = (median.max(1)..colors.len()).find(|&at| value(at) != value(at - 1));
    let at = at.or_else(|| (1..median).rev().find(|&at| value(at) != value(at - 1)));
    colors.split_off(at.unwrap_or(colors.len()))
}

fn mean(colors: &[Counted]) -> Color {
    let count: u64 = colors.iter().map(|&(_, count)| count).sum();
    std::array::from_fn(|channel| {
        let sum: u64 = colors.iter().map(|(color, count)| u64::from(color[channel]) * count).sum();
        ((sum + count / 2) / count.max(1)) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_colors_stay_and_many_become_near_ones() {
        let few = [[1, 2, 3], [200, 0, 0], [1, 2, 3], [1, 2, 4]];
        let (colors, places) = palette(few.into_iter(), 3);
        assert!(colors.len() == 3 && few.iter().all(|color| colors[places[color]] == *color), "{colors:?}");
        assert_eq!(palette(std::iter::empty(), 3).0, [[0; 3]; 0]);
        assert_eq!(palette([[9; 3]; 1000].into_iter(), 3).0, [[9; 3]]);

        // All greens and blues: each becomes one at most a sixteenth of the range away.
        let many: Vec<Color> = (0..=u16::MAX).map(|n| [7, n.to_be_bytes()[0], n.to_be_bytes()[1]]).collect();
        let (colors, places) = palette(many.iter().copied(), 255);
        assert_eq!(colors.len(), 255);
        for color in &many {
            let near = colors[places[color]];
            assert!((0..3).all(|channel| color[channel].abs_diff(near[channel]) <= 16), "{color:?} as {near:?}");
        }
    }
}
