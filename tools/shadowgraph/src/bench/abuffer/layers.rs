//! Layers of one colour over a picture, as fragments for every technique.

use shadowgraph::graph::RasterPass;
use shadowgraph::shader::Program;
use shadowgraph::shader::generated::bench::{self as shaders, layers_vert};
use shadowgraph::shader::generated::transparency::abuffer::count_multisampled_frag;
use shadowgraph::shader::generated::transparency::count_frag;
use shadowgraph::techniques::transparency::fragments::{Draw, Fragments, Step};

/// Near plane, metres.
pub const NEAR: f32 = 0.1;

/// How long the pixels' lists are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lengths {
    /// All as long.
    Constant(u32),
    /// Four, and as many more as are said in the middle 64th of the picture.
    Spot(u32),
    /// By an exponential distribution of this mean, up to eight times as long.
    Exponential(u32),
}

/// Layers.
#[derive(Clone, Copy)]
pub struct Layers {
    pub size: [u32; 2],
    pub lengths: Lengths,
}

impl Layers {
    /// So many over the whole picture.
    pub fn constant(size: [u32; 2], count: u32) -> Self {
        Self { size, lengths: Lengths::Constant(count) }
    }

    /// Of each layer: offset and size, pixels.
    fn areas(&self) -> Vec<[[u32; 2]; 2]> {
        let [width, height] = self.size;
        let whole = [[0; 2], self.size];
        match self.lengths {
            Lengths::Constant(count) => vec![whole; count as usize],
            Lengths::Spot(more) => {
                let middle = [self.size.map(|side| side * 7 / 16), self.size.map(|side| side / 8)];
                [vec![whole; 4], vec![middle; more as usize]].concat()
            }
            Lengths::Exponential(mean) => {
                let share = |layer: u32| (-f64::from(layer) / f64::from(mean)).exp();
                let columns = (0..8 * mean).map(|layer| (f64::from(width) * share(layer)).round() as u32);
                columns.map(|columns| [[0; 2], [columns, height]]).filter(|[_, size]| size[0] > 0).collect()
            }
        }
    }

    /// In all.
    pub fn fragments(&self) -> f64 {
        self.areas().iter().map(|[_, size]| f64::from(size[0]) * f64::from(size[1])).sum()
    }

    /// Pixels that have a layer: those of the first, which is the largest.
    pub fn pixels(&self) -> f64 {
        self.areas().first().map_or(0.0, |[_, size]| f64::from(size[0]) * f64::from(size[1]))
    }
}

impl<'f> Fragments<'f> for Layers {
    fn programs(&self, step: Step) -> Vec<Program> {
        let fragment = match step {
            Step::Samples => None,
            Step::Count => Some(&count_frag::SHADER),
            Step::Arrays => Some(&shaders::layers_array_frag::SHADER),
            Step::ArraysInOrder => Some(&shaders::layers_array_in_order_frag::SHADER),
            Step::Lists => Some(&shaders::layers_list_frag::SHADER),
            Step::SubgroupLists => Some(&shaders::layers_list_subgroup_frag::SHADER),
            Step::CountMultisampled => Some(&count_multisampled_frag::SHADER),
            Step::ArraysMultisampled => Some(&shaders::layers_array_multisampled_frag::SHADER),
            Step::ListsMultisampled => Some(&shaders::layers_list_multisampled_frag::SHADER),
            Step::Peel => Some(&shaders::layers_peel_frag::SHADER),
            Step::PeelBothEnds => Some(&shaders::layers_peel_both_ends_frag::SHADER),
            Step::Weigh => Some(&shaders::layers_weigh_frag::SHADER),
            Step::KeepDepths => Some(&shaders::layers_keep_depths_frag::SHADER),
            Step::KeepTags => Some(&shaders::layers_keep_tags_frag::SHADER),
            Step::KeepColors => Some(&shaders::layers_keep_colors_frag::SHADER),
            Step::AddMoments => Some(&shaders::layers_add_moments_frag::SHADER),
            Step::AddByMoments => Some(&shaders::layers_add_by_moments_frag::SHADER),
            Step::SampleDepths => Some(&shaders::layers_sample_depths_frag::SHADER),
            Step::AddBySamples => Some(&shaders::layers_add_by_samples_frag::SHADER),
        };
        vec![Program::new(&layers_vert::SHADER, fragment)]
    }

    fn bind(&self, _: &mut RasterPass<'_, 'f>, _: Step) {}

    fn draw(&self, _: Step) -> Draw<'f> {
        let areas = self.areas();
        Box::new(move |recorder| {
            let mut first = 0;
            // Layers of one area at once.
            for same in areas.chunk_by(|a, b| a == b) {
                let [offset, size] = same[0];
                let end = first + same.len() as u32;
                recorder.scissor(offset, size);
                recorder.push(&end);
                recorder.draw(0..3, first..end);
                first = end;
            }
            Ok(())
        })
    }

    fn distances(&self) -> [f32; 2] {
        // Depths from one near plane on.
        [NEAR, NEAR * (1 << 24) as f32]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_the_fragments_that_they_say() {
        let layers = |lengths| Layers { size: [256, 64], lengths };
        assert_eq!(layers(Lengths::Constant(3)).fragments(), 3.0 * 256.0 * 64.0);
        assert_eq!(layers(Lengths::Spot(100)).fragments(), 4.0 * 256.0 * 64.0 + 100.0 * 32.0 * 8.0);
        let mean = layers(Lengths::Exponential(8)).fragments() / (256.0 * 64.0);
        assert!((mean - 8.5).abs() < 0.2, "{mean}");
    }
}
