//! Typed reads of accessors, checked before the first byte is followed. glTF 2.0, section 3.6.2.

use ::gltf::json::{
    self,
    accessor::{ComponentType, Type},
    validation::Checked,
};

use super::File;
use crate::error::Result;

/// Index of an accessor.
pub type Index = json::Index<json::Accessor>;

/// An accessor whose bytes are known to be there.
pub struct Elements<'a> {
    /// From the first element to the end of the last; `None` stands for zeros.
    bytes: Option<&'a [u8]>,
    stride: usize,
    /// Number of elements.
    pub count: usize,
    /// Type of an element.
    pub kind: Type,
    /// Type of its components.
    pub component: ComponentType,
    normalized: bool,
    /// Which elements are replaced, and by what.
    sparse: Option<(Vec<u32>, &'a [u8])>,
}

impl<'a> File<'a> {
    /// Checks an accessor. `at` is the place that uses it.
    pub fn elements(&'a self, index: Index, at: &str) -> Result<Elements<'a>> {
        let accessors = &self.root.accessors;
        let Some(accessor) = accessors.get(index.value()) else {
            return Err(self.error(at, format!("uses accessor {}, but there are {}", index.value(), accessors.len())));
        };
        let at = format!("{at}, accessor {}", index.value());
        let fail = |what: String| self.error(&at, what);

        let (Checked::Valid(kind), Checked::Valid(component)) = (accessor.type_, accessor.component_type) else {
            return Err(fail("has a type or component type that glTF does not know".into()));
        };
        let component = component.0;
        let size = kind.multiplicity() * component.size();
        let count = usize::try_from(accessor.count.0).unwrap_or(usize::MAX);

        // 1. The elements themselves, in a row or interleaved with others.
        let mut stride = size;
        let mut bytes = None;
        if let Some(view) = accessor.buffer_view {
            let data = self.view(view, &at)?;
            let view = self.root.buffer_views.get(view.value());
            stride = view.and_then(|view| view.byte_stride).map_or(size, |stride| stride.0);
            if stride < size {
                return Err(fail(format!("elements of {size} bytes do not fit a byteStride of {stride}")));
            }
            let offset = accessor.byte_offset.unwrap_or_default().0;
            bytes = Some(run(data, offset, stride, size, count).map_err(fail)?);
        }

        // 2. What replaces some of them.
        let sparse = match &accessor.sparse {
            Some(sparse) => Some(self.sparse(sparse, count, size, &at)?),
            None => None,
        };
        Ok(Elements { bytes, stride, count, kind, component, normalized: accessor.normalized, sparse })
    }

    fn sparse(
        &'a self,
        sparse: &json::accessor::sparse::Sparse,
        elements: usize,
        size: usize,
        at: &str,
    ) -> Result<(Vec<u32>, &'a [u8])> {
        let fail = |what: String| self.error(at, format!("sparse: {what}"));
        let Checked::Valid(component) = sparse.indices.component_type else {
            return Err(fail("indices have a component type that glTF does not know".into()));
        };
        let count = usize::try_from(sparse.count.0).unwrap_or(usize::MAX);
        let width = component.0.size();
        let data = self.view(sparse.indices.buffer_view, at)?;
        let data = run(data, sparse.indices.byte_offset.0, width, width, count).map_err(fail)?;
        let values = self.view(sparse.values.buffer_view, at)?;
        let values = run(values, sparse.values.byte_offset.0, size, size, count).map_err(fail)?;
        self.spend(data.len() as u64 * 4, at)?;
        let indices = unsigned(data.chunks(width), component.0);
        if let Some(index) = indices.iter().find(|&&index| index as usize >= elements) {
            return Err(fail(format!("index {index} is out of range: there are {elements} elements")));
        }
        Ok((indices, values))
    }

    /// Elements of `N` components as floats; normalised integers become 0 to 1 or −1 to 1 (section 3.11).
    pub fn floats<const N: usize>(&self, elements: &Elements, at: &str) -> Result<Vec<[f32; N]>> {
        if elements.kind.multiplicity() != N {
            let what = format!("{:?} is not allowed here: {N} components are needed", elements.kind);
            return Err(self.error(at, what));
        }
        if elements.component == ComponentType::U32 {
            return Err(self.error(at, "32-bit integers are not allowed here"));
        }
        self.spend((elements.count as u64).saturating_mul(N as u64 * 4), at)?;
        let normal = elements.normalized;
        Ok(match elements.component {
            ComponentType::F32 => elements.gather(f32::from_le_bytes),
            ComponentType::U8 if normal => elements.gather(|[v]: [u8; 1]| f32::from(v) / 255.0),
            ComponentType::U8 => elements.gather(|[v]: [u8; 1]| f32::from(v)),
            ComponentType::I8 if normal => elements.gather(|[v]: [u8; 1]| (f32::from(v as i8) / 127.0).max(-1.0)),
            ComponentType::I8 => elements.gather(|[v]: [u8; 1]| f32::from(v as i8)),
            ComponentType::U16 if normal => elements.gather(|v| f32::from(u16::from_le_bytes(v)) / 65535.0),
            ComponentType::U16 => elements.gather(|v| f32::from(u16::from_le_bytes(v))),
            ComponentType::I16 if normal => elements.gather(|v| (f32::from(i16::from_le_bytes(v)) / 32767.0).max(-1.0)),
            ComponentType::I16 => elements.gather(|v| f32::from(i16::from_le_bytes(v))),
            ComponentType::U32 => Vec::new(),
        })
    }

    /// Elements of `N` unsigned integers.
    pub fn integers<const N: usize>(&self, elements: &Elements, at: &str) -> Result<Vec<[u32; N]>> {
        if elements.kind.multiplicity() != N {
            let what = format!("{:?} is not allowed here: {N} components are needed", elements.kind);
            return Err(self.error(at, what));
        }
        self.spend((elements.count as u64).saturating_mul(N as u64 * 4), at)?;
        match elements.component {
            ComponentType::U8 => Ok(elements.gather(|[v]: [u8; 1]| u32::from(v))),
            ComponentType::U16 => Ok(elements.gather(|v| u32::from(u16::from_le_bytes(v)))),
            ComponentType::U32 => Ok(elements.gather(u32::from_le_bytes)),
            other => Err(self.error(at, format!("{other:?} is not allowed here: unsigned integers are needed"))),
        }
    }
}

impl Elements<'_> {
    /// All elements; `convert` takes the `S` bytes of a component. The caller has matched `N` and `S` to the type.
    fn gather<const N: usize, const S: usize, T: Copy + Default>(&self, convert: impl Fn([u8; S]) -> T) -> Vec<[T; N]> {
        let element = |bytes: &[u8]| {
            let components = bytes.as_chunks::<S>().0;
            std::array::from_fn(|i| components.get(i).map_or(T::default(), |&component| convert(component)))
        };
        let mut all: Vec<[T; N]> = match self.bytes {
            Some(bytes) => bytes.chunks(self.stride).map(element).collect(),
            None => vec![[T::default(); N]; self.count],
        };
        if let Some((indices, values)) = &self.sparse {
            for (&index, value) in indices.iter().zip(values.chunks(N * S)) {
                if let Some(place) = all.get_mut(index as usize) {
                    *place = element(value);
                }
            }
        }
        all
    }
}

/// The bytes from the first element to the end of the last.
fn run(data: &[u8], offset: u64, stride: usize, size: usize, count: usize) -> Result<&[u8], String> {
    let length = match count {
        0 => Some(0),
        _ => stride.checked_mul(count - 1).and_then(|last| last.checked_add(size)),
    };
    let bytes = usize::try_from(offset).ok().zip(length).and_then(|(start, length)| {
        let end = start.checked_add(length)?;
        data.get(start..end)
    });
    bytes.ok_or_else(|| {
        let all = data.len();
        format!("{count} elements of {size} bytes, {stride} apart, from byte {offset} are not within its {all} bytes")
    })
}

fn unsigned<'a>(words: impl Iterator<Item = &'a [u8]>, component: ComponentType) -> Vec<u32> {
    let value = |word: &[u8]| match (component, word) {
        (ComponentType::U8, &[a]) => u32::from(a),
        (ComponentType::U16, &[a, b]) => u32::from(u16::from_le_bytes([a, b])),
        (_, &[a, b, c, d]) => u32::from_le_bytes([a, b, c, d]),
        _ => u32::MAX,
    };
    words.map(value).collect()
}
