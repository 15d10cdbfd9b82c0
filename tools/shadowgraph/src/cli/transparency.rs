//! Which technique of transparency, and its settings.

use clap::ValueEnum;
use shadowgraph::frame::Transparency;
use shadowgraph::techniques::transparency::adaptive::Adaptive;
use shadowgraph::techniques::transparency::kbuffer::KBuffer;
use shadowgraph::techniques::transparency::stochastic::Stochastic;
use shadowgraph::techniques::transparency::weighted::{Weight, Weighted};

use super::FrameArguments;
use crate::failure::{Failure, Result};

/// How blended surfaces are composited.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TransparencyKind {
    /// Object by object, far ones first.
    Sorted,
    /// Every layer of every pixel, by depth.
    #[value(name = "abuffer")]
    ABuffer,
    /// Every layer of every pixel, one a pass from the front.
    DepthPeeling,
    /// Every layer of every pixel, two a pass from both ends.
    DualDepthPeeling,
    /// All layers averaged, the nearer ones with more weight (--weight).
    Weighted,
    /// The nearest layers of every pixel (--kept), and an average of all others behind them.
    #[value(name = "kbuffer")]
    KBuffer,
    /// All layers, as visible as a step function of few nodes tells (--kept).
    Adaptive,
    /// All layers, as visible as four moments of what hides them tell.
    Moments,
    /// All layers, as visible as random samples tell (--samples).
    Stochastic,
}

impl FrameArguments {
    /// The technique of transparency with its settings. Bad usage where one is given that the technique does not have.
    pub fn transparency(&self) -> Result<Transparency> {
        use TransparencyKind as Kind;
        let options = [
            ("--kept", self.kept, &[Kind::KBuffer, Kind::Adaptive][..], "kbuffer or adaptive"),
            ("--samples", self.samples, &[Kind::Stochastic], "stochastic"),
            ("--weight", self.weight, &[Kind::Weighted], "weighted"),
            ("--abuffer-samples", self.abuffer_samples, &[Kind::ABuffer], "abuffer"),
        ];
        if let Some((option, .., name)) =
            options.iter().find(|(_, value, kinds, _)| value.is_some() && !kinds.contains(&self.transparency))
        {
            return Err(Failure::input(format!("{option} belongs to --transparency {name}")));
        }
        Ok(match self.transparency {
            Kind::Sorted => Transparency::Sorted,
            Kind::ABuffer => Transparency::ABuffer,
            Kind::DepthPeeling => Transparency::DepthPeeling(Default::default()),
            Kind::DualDepthPeeling => Transparency::DualDepthPeeling(Default::default()),
            Kind::Weighted => {
                let weight = match self.weight {
                    Some(8) => Weight::Equation8,
                    Some(9) => Weight::Equation9,
                    Some(10) => Weight::Equation10,
                    _ => Weight::Equation7,
                };
                Transparency::Weighted(Weighted { weight })
            }
            Kind::KBuffer => {
                let default = KBuffer::default();
                Transparency::KBuffer(KBuffer { kept: self.kept.unwrap_or(default.kept) })
            }
            Kind::Adaptive => {
                let default = Adaptive::default();
                Transparency::Adaptive(Adaptive { kept: self.kept.unwrap_or(default.kept) })
            }
            Kind::Moments => Transparency::Moments(Default::default()),
            Kind::Stochastic => {
                let default = Stochastic::default();
                Transparency::Stochastic(Stochastic { samples: self.samples.unwrap_or(default.samples) })
            }
        })
    }
}
