//! The few SPIR-V instructions that reflection proper does not cover.

use std::collections::BTreeMap;

use spirq::spirv::{Capability, Op};

/// Words before the first instruction.
const HEADER: usize = 5;

/// Instructions, each with its head word.
fn instructions(words: &[u32]) -> impl Iterator<Item = (u32, &[u32])> {
    let mut rest = words.get(HEADER..).unwrap_or_default();
    std::iter::from_fn(move || {
        let head = *rest.first()?;
        let (instruction, tail) = rest.split_at_checked((head >> 16).max(1) as usize)?;
        rest = tail;
        Some((head & 0xffff, instruction))
    })
}

/// Drops source text and lines, so that an edit of a comment changes nothing. Names stay: reflection reads them, and
/// debuggers show them.
pub fn strip(words: &[u32]) -> Vec<u32> {
    // Instructions of a non-semantic set (`debugPrintfEXT`) refer to strings.
    let has_strings = instructions(words).any(|(op, instruction)| {
        op == Op::ExtInstImport as u32 && instruction.get(2..4).is_some_and(|name| bytes(name) == *b"NonSeman")
    });
    let dropped = |op: u32| {
        [Op::Source, Op::SourceContinued, Op::SourceExtension, Op::Line, Op::NoLine, Op::ModuleProcessed]
            .into_iter()
            .chain((!has_strings).then_some(Op::String))
            .any(|other| op == other as u32)
    };
    let kept = instructions(words).filter(|(op, _)| !dropped(*op)).flat_map(|(_, instruction)| instruction);
    words.iter().take(HEADER).chain(kept).copied().collect()
}

fn bytes(words: &[u32]) -> [u8; 8] {
    let mut bytes = [0; 8];
    for (to, word) in bytes.chunks_exact_mut(4).zip(words) {
        to.copy_from_slice(&word.to_le_bytes());
    }
    bytes
}

/// Length that [`for_reflection`] gives to arrays whose length is not known before specialization.
pub const SPECIALIZED: u32 = 0x7fff_ffff;

/// The words as `spirq` can read them. It evaluates expressions of specialization constants, but not all kinds, and
/// fails on the others: they are left out, and an array that is as long as one gets the length [`SPECIALIZED`].
pub fn for_reflection(words: &[u32]) -> Vec<u32> {
    let mut result: Vec<u32> = words.iter().take(HEADER).copied().collect();
    let mut next = result.get(3).copied().unwrap_or_default();
    let mut type_of = BTreeMap::new();
    for (op, instruction) in instructions(words) {
        match *instruction {
            [_, ty, id, ..] if op == Op::SpecConstantOp as u32 => drop(type_of.insert(id, ty)),
            [head, id, element, length] if op == Op::TypeArray as u32 && type_of.contains_key(&length) => {
                result.extend([4 << 16 | Op::Constant as u32, type_of[&length], next, SPECIALIZED]);
                result.extend([head, id, element, next]);
                next += 1;
            }
            [_, ty, id, ..] if op == Op::SpecConstant as u32 => {
                type_of.insert(id, ty);
                result.extend(instruction);
            }
            _ => result.extend(instruction),
        }
    }
    if let Some(bound) = result.get_mut(3) {
        *bound = next;
    }
    result
}

/// Capabilities that Vulkan 1.3 does not promise of every device, by their SPIR-V names, sorted.
pub fn capabilities(words: &[u32]) -> Vec<String> {
    let declared = instructions(words).filter(|(op, _)| *op == Op::Capability as u32);
    let mut names: Vec<String> = declared
        .filter_map(|(_, instruction)| instruction.get(1).copied())
        .filter_map(|number| match Capability::from_u32(number) {
            Some(capability) if is_promised(capability) => None,
            Some(capability) => Some(format!("{capability:?}")),
            None => Some(format!("capability {number}")),
        })
        .collect();
    names.sort();
    names
}

/// Vulkan 1.3, "Version Requirements" of features, and the table of capabilities in appendix A.
fn is_promised(capability: Capability) -> bool {
    matches!(
        capability,
        Capability::Matrix
            | Capability::Shader
            | Capability::InputAttachment
            | Capability::Sampled1D
            | Capability::Image1D
            | Capability::SampledBuffer
            | Capability::ImageBuffer
            | Capability::ImageQuery
            | Capability::DerivativeControl
            | Capability::DeviceGroup
            | Capability::MultiView
            | Capability::GroupNonUniform
            | Capability::VulkanMemoryModel
            | Capability::VulkanMemoryModelDeviceScope
            | Capability::PhysicalStorageBufferAddresses
            | Capability::DemoteToHelperInvocation
            | Capability::DotProduct
            | Capability::DotProductInputAll
            | Capability::DotProductInput4x8Bit
            | Capability::DotProductInput4x8BitPacked
    )
}
