//! NumPy arrays: the NPY format, version 1.0 (NumPy Enhancement Proposal 1).

use std::io::Write;
use std::path::Path;

use super::write_atomically;
use crate::{Error, Result};

/// An element type of [`write_npy`]: `f32`, `u32` or `u8`.
pub trait NpyScalar: bytemuck::Pod + sealed::Little {}
impl NpyScalar for f32 {}
impl NpyScalar for u32 {}
impl NpyScalar for u8 {}

mod sealed {
    pub trait Little: Copy {
        /// NumPy's name of the type, little-endian.
        const DESCRIPTION: &'static str;
        fn append(self, bytes: &mut Vec<u8>);
    }

    macro_rules! little {
        ($scalar:ty, $description:literal) => {
            impl Little for $scalar {
                const DESCRIPTION: &'static str = $description;
                fn append(self, bytes: &mut Vec<u8>) {
                    bytes.extend_from_slice(&self.to_le_bytes());
                }
            }
        };
    }
    little!(f32, "<f4");
    little!(u32, "<u4");
    little!(u8, "|u1");
}

/// Writes an array in row-major order: the last axis of `shape` varies fastest, so an image is `[height, width,
/// channels]`. `numpy.load` reads it. The file appears whole or not at all.
///
/// # Errors
/// [`Error::Invalid`] where `shape` does not hold as many elements as `values`; [`Error::Io`].
pub fn write_npy<T: NpyScalar>(path: &Path, shape: &[usize], values: &[T]) -> Result<()> {
    let elements = shape.iter().try_fold(1_usize, |product, &axis| product.checked_mul(axis));
    if elements != Some(values.len()) {
        return Err(Error::invalid(
            format!("shape {shape:?} of {}", path.display()),
            format!("its axes must multiply to the number of values, {}", values.len()),
        ));
    }
    let header = header(&format!("'{}'", T::DESCRIPTION), shape);
    write_atomically(path, |file| {
        file.write_all(&header)?;
        let mut bytes = Vec::new();
        for block in values.chunks(1 << 16) {
            bytes.clear();
            block.iter().for_each(|value| value.append(&mut bytes));
            file.write_all(&bytes)?;
        }
        Ok(())
    })
}

/// `description`: of the elements, as Python writes it.
pub(super) fn header(description: &str, shape: &[usize]) -> Vec<u8> {
    let axes: String = match shape {
        [one] => format!("{one},"),
        axes => axes.iter().map(usize::to_string).collect::<Vec<_>>().join(", "),
    };
    let mut text = format!("{{'descr': {description}, 'fortran_order': False, 'shape': ({axes}), }}");
    // Magic, version and length take 10 bytes; with the closing line feed the data starts at a multiple of 64.
    let padding = (64 - (10 + text.len() + 1) % 64) % 64;
    text.extend(std::iter::repeat_n(' ', padding));
    text.push('\n');
    let mut header = b"\x93NUMPY\x01\x00".to_vec();
    header.extend_from_slice(&(text.len() as u16).to_le_bytes());
    header.extend_from_slice(text.as_bytes());
    header
}
