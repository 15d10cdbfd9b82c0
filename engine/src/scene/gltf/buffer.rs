//! Buffers of a file, in memory.

use std::{borrow::Cow, path::Path};

use ::gltf::json;

use super::{place, scene_error, uri};
use crate::error::{Error, Result};

/// Loads every buffer; each is cut to the length that the JSON gives.
pub fn load<'a>(path: &Path, root: &json::Root, binary: Option<&'a [u8]>) -> Result<Vec<Cow<'a, [u8]>>> {
    let mut buffers = Vec::with_capacity(root.buffers.len());
    // A small file must not have a large one read many times.
    let mut left = super::FILE_LIMIT;
    for (index, buffer) in root.buffers.iter().enumerate() {
        let at = || place("buffer", index, buffer.name.as_ref());
        let fail = |what: String| scene_error(path, at(), what);
        let data: Cow<'a, [u8]> = match (&buffer.uri, binary) {
            (Some(text), _) => match uri::parse(text).map_err(fail)? {
                uri::Uri::Data(data) => Cow::Owned(data),
                uri::Uri::File(name) => {
                    let whole = path.with_file_name(name);
                    let data = uri::read_file(&whole, left).map_err(|error| match error {
                        Error::Io { path, source, .. } => fail(format!("cannot read {}: {source}", path.display())),
                        other => other,
                    })?;
                    Cow::Owned(data)
                }
            },
            (None, Some(binary)) if index == 0 => Cow::Borrowed(binary),
            (None, _) => return Err(fail("has no data: neither a URI nor the binary chunk of a .glb".into())),
        };
        left = left.saturating_sub(data.len() as u64);
        let length = usize::try_from(buffer.byte_length.0).ok().filter(|&length| length <= data.len());
        let Some(length) = length else {
            let what = format!("says {} bytes, but its data has {}", buffer.byte_length.0, data.len());
            return Err(fail(what));
        };
        buffers.push(match data {
            Cow::Borrowed(data) => Cow::Borrowed(&data[..length]),
            Cow::Owned(mut data) => {
                data.truncate(length);
                Cow::Owned(data)
            }
        });
    }
    Ok(buffers)
}

impl super::File<'_> {
    /// Bytes of a buffer view.
    pub fn view(&self, index: json::Index<json::buffer::View>, at: &str) -> Result<&[u8]> {
        let views = &self.root.buffer_views;
        let Some(view) = views.get(index.value()) else {
            let what = format!("uses bufferView {}, but there are {}", index.value(), views.len());
            return Err(self.error(at, what));
        };
        let here = format!("{at}, bufferView {}", index.value());
        let Some(buffer) = self.buffers.get(view.buffer.value()) else {
            let what = format!("uses buffer {}, but there are {}", view.buffer.value(), self.buffers.len());
            return Err(self.error(here, what));
        };
        let offset = view.byte_offset.unwrap_or_default().0;
        let bytes = offset.checked_add(view.byte_length.0).and_then(|end| {
            let (start, end) = (usize::try_from(offset).ok()?, usize::try_from(end).ok()?);
            buffer.get(start..end)
        });
        bytes.ok_or_else(|| {
            let (length, all) = (view.byte_length.0, buffer.len());
            self.error(here, format!("{length} bytes from byte {offset} are not within a buffer of {all} bytes"))
        })
    }
}
