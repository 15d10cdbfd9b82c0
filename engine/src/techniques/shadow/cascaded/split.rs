//! Where cascades end: Zhang et al. 2006, section 3.1.

/// How the depth range is cut into cascades.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Splits {
    /// Equal lengths.
    Uniform,
    /// Equal ratios: the same perspective error everywhere.
    Logarithmic,
    /// `λ` logarithmic + `1 − λ` uniform; `λ` from 0 to 1.
    Practical(f32),
}

/// Ends of `count` cascades between `near` and `far` (metres along the view axis); the last is `far`.
pub fn split_distances(splits: Splits, count: u32, near: f32, far: f32) -> Vec<f32> {
    let lambda = match splits {
        Splits::Uniform => 0.0,
        Splits::Logarithmic => 1.0,
        Splits::Practical(lambda) => lambda.clamp(0.0, 1.0),
    };
    let end = |i: u32| {
        let share = i as f32 / count as f32;
        let logarithmic = near * (far / near).powf(share);
        let uniform = near + (far - near) * share;
        lambda * logarithmic + (1.0 - lambda) * uniform
    };
    (1..count).map(end).chain([far]).collect()
}
