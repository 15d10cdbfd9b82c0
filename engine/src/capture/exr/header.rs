//! Headers of a file: checks, and bytes.

use std::collections::HashSet;

use exr::math::Vec2;
use exr::meta::attribute::{
    AttributeValue, BlockType, ChannelDescription, ChannelList, Chromaticities, IntegerBounds, LineOrder, SampleType,
    Text, write as write_attribute,
};
use exr::meta::header::standard_names;

use super::Compression;
use crate::capture::{Capture, Metadata, Part, SampleKind, Value};
use crate::{Error, Result};

/// Longest name of an attribute or a channel in bytes; longer than 31 needs a flag in the file's version.
const LONGEST_NAME: usize = 255;
const SHORT_NAME: usize = 31;

/// Attributes that this module writes itself.
const OWN: [&[u8]; 11] = [
    standard_names::CHANNELS,
    standard_names::COMPRESSION,
    standard_names::DATA_WINDOW,
    standard_names::DISPLAY_WINDOW,
    standard_names::LINE_ORDER,
    standard_names::PIXEL_ASPECT,
    standard_names::WINDOW_CENTER,
    standard_names::WINDOW_WIDTH,
    standard_names::NAME,
    standard_names::BLOCK_TYPE,
    standard_names::CHUNKS,
];

/// Refuses what OpenEXR cannot hold.
pub(super) fn check(capture: &Capture) -> Result<()> {
    if capture.parts.is_empty() {
        return Err(Error::invalid("capture", "it has no parts"));
    }
    let mut part_names = HashSet::new();
    for (index, part) in capture.parts.iter().enumerate() {
        if part.name.is_empty() && capture.parts.len() > 1 {
            return Err(Error::invalid(format!("part {index}"), "parts of a file with several need names"));
        }
        if !part_names.insert(&part.name) {
            return Err(Error::invalid(format!("part {:?}", part.name), "two parts have this name"));
        }
        check_part(part)?;
        check_attributes(&part.name, attributes(capture, index), &[])?;
    }
    Ok(())
}

pub(super) fn check_part(part: &Part) -> Result<()> {
    let what = || format!("part {:?}", part.name);
    let [width, height] = part.size;
    if width == 0 || height == 0 || width > i32::MAX as u32 || height > i32::MAX as u32 {
        return Err(Error::invalid(what(), format!("its size {width}×{height} must lie in 1 to {}", i32::MAX)));
    }
    if part.channels.is_empty() {
        return Err(Error::invalid(what(), "it has no channels"));
    }
    let mut names = HashSet::new();
    for channel in &part.channels {
        let what = || format!("channel {:?} of part {:?}", channel.name, part.name);
        check_name(&channel.name).map_err(|why| Error::invalid(what(), why))?;
        if !names.insert(&channel.name) {
            return Err(Error::invalid(what(), "two channels have this name"));
        }
        let pixels = u64::from(width) * u64::from(height);
        if channel.content.len() as u64 != pixels {
            let why = format!("it has {} samples for {width}×{height} pixels", channel.content.len());
            return Err(Error::invalid(what(), why));
        }
    }
    Ok(())
}

/// `own`: names beside [`OWN`] that this module writes itself.
fn check_attributes<'a>(
    part: &str,
    attributes: impl Iterator<Item = &'a (String, Value)>,
    own: &[&[u8]],
) -> Result<()> {
    let mut names = HashSet::new();
    for (name, _) in attributes {
        let what = || format!("attribute {name:?} of part {part:?}");
        check_name(name).map_err(|why| Error::invalid(what(), why))?;
        if OWN.iter().chain(own).any(|own| *own == name.as_bytes()) {
            return Err(Error::invalid(what(), "OpenEXR gives this name a meaning of its own"));
        }
        if !names.insert(name) {
            return Err(Error::invalid(what(), "two attributes have this name"));
        }
    }
    Ok(())
}

fn check_name(name: &str) -> Result<(), String> {
    match name.len() {
        0 => Err("its name is empty".into()),
        1..=LONGEST_NAME if !name.contains('\0') => Ok(()),
        1..=LONGEST_NAME => Err("its name holds a zero byte".into()),
        length => Err(format!("its name has {length} bytes, OpenEXR allows {LONGEST_NAME}")),
    }
}

/// Attributes of a part beyond those of its layout: the frame's go to the first.
fn attributes(capture: &Capture, part: usize) -> impl Iterator<Item = &(String, Value)> {
    let frame: &[(String, Value)] = if part == 0 { &capture.metadata.0 } else { &[] };
    frame.iter().chain(shared(&capture.metadata, part)).chain(&capture.parts[part].metadata.0)
}

/// OpenEXR wants chromaticities equal in all parts, so that the frame's go to the others as well.
fn shared(metadata: &Metadata, part: usize) -> impl Iterator<Item = &(String, Value)> {
    metadata.0.iter().filter(move |(name, _)| part > 0 && name == "chromaticities")
}

/// Everything before the table of offsets.
pub(super) fn encode(capture: &Capture, compression: Compression) -> Result<Vec<u8>> {
    let multi_part = capture.parts.len() > 1;
    let mut flags = if has_long_names(capture) { LONG_NAMES } else { 0 };
    flags |= if multi_part { MULTI_PART } else { 0 };
    let mut bytes = begin(flags);
    for (index, part) in capture.parts.iter().enumerate() {
        let layout = Layout {
            name: &part.name,
            kind: BlockType::ScanLine,
            chunks: part.size[1].div_ceil(compression.lines() as u32),
            channels: channel_list(part),
            compression,
            size: part.size,
            display: capture.parts[0].size,
        };
        for (name, value) in layout.attributes() {
            put(name, &value, &mut bytes)?;
        }
        for (name, value) in attributes(capture, index) {
            put(name.as_bytes(), &to_attribute(value), &mut bytes)?;
        }
        bytes.push(0);
    }
    if multi_part {
        bytes.push(0);
    }
    Ok(bytes)
}

fn has_long_names(capture: &Capture) -> bool {
    let channels = capture.parts.iter().flat_map(|part| part.channels.iter().map(|channel| &channel.name));
    let part_attributes = capture.parts.iter().flat_map(|part| part.metadata.0.iter().map(|(name, _)| name));
    let frame_attributes = capture.metadata.0.iter().map(|(name, _)| name);
    channels.chain(part_attributes).chain(frame_attributes).any(|name| name.len() > SHORT_NAME)
}

/// Everything before the table of offsets of a file with one deep part. `most`: samples of a pixel.
pub(super) fn encode_deep(layout: &Layout, most: i32, metadata: &Metadata) -> Result<Vec<u8>> {
    const VERSION: &[u8] = b"version";
    const MOST: &[u8] = b"maxSamplesPerPixel";
    check_attributes("deep", metadata.0.iter(), &[VERSION, MOST])?;
    let long = metadata.0.iter().any(|(name, _)| name.len() > SHORT_NAME);
    let mut bytes = begin(NOT_FLAT | if long { LONG_NAMES } else { 0 });
    for (name, value) in layout.attributes() {
        put(name, &value, &mut bytes)?;
    }
    put(VERSION, &AttributeValue::I32(1), &mut bytes)?;
    put(MOST, &AttributeValue::I32(most), &mut bytes)?;
    for (name, value) in &metadata.0 {
        put(name.as_bytes(), &to_attribute(value), &mut bytes)?;
    }
    bytes.push(0);
    Ok(bytes)
}

/// Flags in the file's version.
const LONG_NAMES: u32 = 0x400;
const NOT_FLAT: u32 = 0x800;
const MULTI_PART: u32 = 0x1000;

/// The first bytes of a file.
fn begin(flags: u32) -> Vec<u8> {
    const MAGIC: u32 = 20_000_630;
    const VERSION: u32 = 2;
    [MAGIC, VERSION | flags].iter().flat_map(|word| word.to_le_bytes()).collect()
}

fn put(name: &[u8], value: &AttributeValue, bytes: &mut Vec<u8>) -> Result<()> {
    write_attribute(name, value, bytes)
        .map_err(|e| Error::invalid(format!("attribute {:?}", String::from_utf8_lossy(name)), e.to_string()))
}

/// How a part lies in the file.
pub(super) struct Layout<'a> {
    pub(super) name: &'a str,
    pub(super) kind: BlockType,
    pub(super) chunks: u32,
    pub(super) channels: ChannelList,
    pub(super) compression: Compression,
    pub(super) size: [u32; 2],
    /// One for the whole file: the frame's.
    pub(super) display: [u32; 2],
}

impl Layout<'_> {
    fn attributes(&self) -> [(&'static [u8], AttributeValue); 11] {
        let window = |[width, height]: [u32; 2]| {
            AttributeValue::IntegerBounds(IntegerBounds::new(Vec2(0, 0), Vec2(width as usize, height as usize)))
        };
        [
            (standard_names::NAME, AttributeValue::Text(text(self.name))),
            (standard_names::BLOCK_TYPE, AttributeValue::BlockType(self.kind)),
            (standard_names::CHUNKS, AttributeValue::I32(self.chunks as i32)),
            (standard_names::CHANNELS, AttributeValue::ChannelList(self.channels.clone())),
            (standard_names::COMPRESSION, AttributeValue::Compression(self.compression.in_file())),
            (standard_names::DATA_WINDOW, window(self.size)),
            (standard_names::DISPLAY_WINDOW, window(self.display)),
            (standard_names::LINE_ORDER, AttributeValue::LineOrder(LineOrder::Increasing)),
            (standard_names::PIXEL_ASPECT, AttributeValue::F32(1.0)),
            (standard_names::WINDOW_CENTER, AttributeValue::FloatVec2(Vec2(0.0, 0.0))),
            (standard_names::WINDOW_WIDTH, AttributeValue::F32(1.0)),
        ]
    }
}

/// Channels of a part in the order of the file: by the bytes of their names.
pub(super) fn sorted(part: &Part) -> Vec<&crate::capture::Channel> {
    let mut channels: Vec<_> = part.channels.iter().collect();
    channels.sort_by(|a, b| a.name.as_bytes().cmp(b.name.as_bytes()));
    channels
}

pub(super) fn channel_list(part: &Part) -> ChannelList {
    let channels = sorted(part).into_iter().map(|channel| {
        let kind = match channel.content.kind() {
            SampleKind::F16 => SampleType::F16,
            SampleKind::F32 => SampleType::F32,
            SampleKind::U32 => SampleType::U32,
        };
        (&channel.name[..], kind)
    });
    self::channels(channels)
}

/// From names in the order of the file, and what their samples are.
pub(super) fn channels<'a>(channels: impl Iterator<Item = (&'a str, SampleType)>) -> ChannelList {
    ChannelList::new(channels.map(|(name, kind)| ChannelDescription::new(text(name), kind, false)).collect())
}

/// OpenEXR's strings are bytes; ours are UTF-8, as its own tools write them.
fn text(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}

fn to_attribute(value: &Value) -> AttributeValue {
    match value {
        Value::Text(value) => AttributeValue::Text(text(value)),
        Value::I32(value) => AttributeValue::I32(*value),
        Value::F32(value) => AttributeValue::F32(*value),
        Value::F64(value) => AttributeValue::F64(*value),
        Value::Vec2(v) => AttributeValue::FloatVec2(Vec2(v.x, v.y)),
        Value::Vec3(v) => AttributeValue::FloatVec3((v.x, v.y, v.z)),
        Value::Mat4(matrix) => AttributeValue::Matrix4x4(matrix.to_cols_array()),
        Value::Chromaticities([red, green, blue, white]) => AttributeValue::Chromaticities(Chromaticities {
            red: Vec2(red.x, red.y),
            green: Vec2(green.x, green.y),
            blue: Vec2(blue.x, blue.y),
            white: Vec2(white.x, white.y),
        }),
    }
}
