//! Narrowing to half-floats that says what it changed.

use half::f16;
use half::slice::HalfFloatSliceExt;

/// What narrowing to 16 bits changed beyond rounding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HalfReport {
    /// Values beyond ±65504, infinities included, which became ±65504.
    pub clamped: u64,
    /// Values that are not a number; they stay so.
    pub not_a_number: u64,
}

impl std::ops::AddAssign for HalfReport {
    fn add_assign(&mut self, other: Self) {
        self.clamped += other.clamped;
        self.not_a_number += other.not_a_number;
    }
}

/// Rounds to the nearest half-float, ties to even. What a half-float cannot hold is clamped to ±65504, the greatest
/// it can, and counted. Values below its range become subnormal or zero, as rounding has it.
pub fn to_half(values: &[f32]) -> (Vec<f16>, HalfReport) {
    const GREATEST: f32 = 65504.0;
    const BLOCK: usize = 1024;
    let mut halves = vec![f16::ZERO; values.len()];
    let mut report = HalfReport::default();
    let mut clamped = [0.0; BLOCK];
    for (block, out) in values.chunks(BLOCK).zip(halves.chunks_mut(BLOCK)) {
        let clamped = &mut clamped[..block.len()];
        let (mut beyond, mut not_a_number) = (0_u32, 0_u32);
        for (to, &from) in clamped.iter_mut().zip(block) {
            beyond += u32::from(from.abs() > GREATEST);
            not_a_number += u32::from(from.is_nan());
            *to = from.clamp(-GREATEST, GREATEST);
        }
        out.convert_from_f32_slice(clamped);
        report.clamped += u64::from(beyond);
        report.not_a_number += u64::from(not_a_number);
    }
    (halves, report)
}
