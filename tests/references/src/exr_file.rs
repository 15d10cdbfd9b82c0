//! OpenEXR files as tests look at them: every channel of every part, by name.

use std::collections::BTreeMap;
use std::path::Path;

use exr::prelude::{AnyChannels, FlatSamples, Image, Layers, ReadChannels, ReadLayers, read};

/// A file.
#[derive(Clone, Debug)]
pub struct ExrFile {
    /// Parts in the order of the file.
    pub parts: Vec<Part>,
}

/// A part of a file.
#[derive(Clone, Debug)]
pub struct Part {
    /// Name; empty where the file gives none.
    pub name: String,
    /// Width and height of the data window.
    pub size: [u32; 2],
    /// By full name, such as `N.X`.
    pub channels: BTreeMap<String, Channel>,
    /// Attributes of the header without a meaning to the format, of kind text, by name.
    pub texts: BTreeMap<String, String>,
}

/// Samples of a channel, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub enum Channel {
    /// HALF, widened.
    Half(Vec<f32>),
    /// FLOAT.
    Float(Vec<f32>),
    /// UINT.
    Uint(Vec<u32>),
}

/// Everything in a file. Panics, with the file's name, where it cannot be read. Here and not in each test, as the crate's
/// reader is compiled anew for every one that names it.
pub fn image(path: &Path) -> Image<Layers<AnyChannels<FlatSamples>>> {
    let reader = read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
    reader.from_file(path).unwrap_or_else(|error| panic!("cannot read {}: {error}", path.display()))
}

impl ExrFile {
    /// Reads a file. Panics, with the file's name, where it cannot: this is for tests.
    pub fn read(path: &Path) -> Self {
        let image = image(path);
        let shared = texts(&image.attributes.other);
        let parts = image.layer_data.iter().map(|layer| {
            let channels = layer.channel_data.list.iter().map(|channel| {
                let samples = match &channel.sample_data {
                    FlatSamples::F16(values) => Channel::Half(values.iter().map(|v| v.to_f32()).collect()),
                    FlatSamples::F32(values) => Channel::Float(values.clone()),
                    FlatSamples::U32(values) => Channel::Uint(values.clone()),
                };
                (channel.name.to_string(), samples)
            });
            let mut all = shared.clone();
            all.extend(texts(&layer.attributes.other));
            Part {
                name: layer.attributes.layer_name.as_ref().map_or(String::new(), |name| name.to_string()),
                size: [layer.size.width() as u32, layer.size.height() as u32],
                channels: channels.collect(),
                texts: all,
            }
        });
        Self { parts: parts.collect() }
    }

    /// The part of a name. Panics with the names there are where it is missing.
    pub fn part(&self, name: &str) -> &Part {
        let names: Vec<_> = self.parts.iter().map(|p| &p.name).collect();
        self.parts.iter().find(|p| p.name == name).unwrap_or_else(|| panic!("no part {name:?} among {names:?}"))
    }
}

impl Part {
    /// Samples of a HALF or FLOAT channel. Panics with the names there are where it is missing or UINT.
    pub fn floats(&self, channel: &str) -> &[f32] {
        match self.channel(channel) {
            Channel::Half(values) | Channel::Float(values) => values,
            Channel::Uint(_) => panic!("channel {channel} of part {:?} is UINT, not HALF or FLOAT", self.name),
        }
    }

    /// Samples of a UINT channel. Panics with the names there are where it is missing or of another type.
    pub fn uints(&self, channel: &str) -> &[u32] {
        match self.channel(channel) {
            Channel::Uint(values) => values,
            _ => panic!("channel {channel} of part {:?} is not UINT", self.name),
        }
    }

    /// A channel. Panics with the names there are where it is missing.
    pub fn channel(&self, channel: &str) -> &Channel {
        let names: Vec<_> = self.channels.keys().collect();
        self.channels
            .get(channel)
            .unwrap_or_else(|| panic!("no channel {channel} in part {:?} among {names:?}", self.name))
    }

    /// Three channels `PREFIX` + suffix as vectors, pixel by pixel: `vectors("N.", ["X", "Y", "Z"])`.
    pub fn vectors(&self, prefix: &str, suffixes: [&str; 3]) -> Vec<glam::DVec3> {
        let [x, y, z] = suffixes.map(|suffix| self.floats(&format!("{prefix}{suffix}")));
        (0..x.len()).map(|i| glam::Vec3::new(x[i], y[i], z[i]).as_dvec3()).collect()
    }
}

fn texts(
    attributes: &std::collections::HashMap<exr::meta::attribute::Text, exr::meta::attribute::AttributeValue>,
) -> BTreeMap<String, String> {
    let text = |value: &exr::meta::attribute::AttributeValue| match value {
        exr::meta::attribute::AttributeValue::Text(text) => Some(text.to_string()),
        _ => None,
    };
    attributes.iter().filter_map(|(name, value)| Some((name.to_string(), text(value)?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::*;

    #[test]
    fn reads_every_type_of_channel_of_every_part() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("two.exr");
        let channels = |names: &[(&str, FlatSamples)]| {
            AnyChannels::sort(names.iter().map(|(name, s)| AnyChannel::new(*name, s.clone())).collect())
        };
        let first = channels(&[
            ("R", FlatSamples::F16(vec![f16::from_f32(0.5), f16::from_f32(2.0)])),
            ("Z", FlatSamples::F32(vec![1.25, f32::INFINITY])),
            ("id.object", FlatSamples::U32(vec![7, u32::MAX])),
        ]);
        let second = channels(&[("depth", FlatSamples::F32(vec![3.0]))]);
        let mut attributes = LayerAttributes::named("picture");
        attributes.other.insert(Text::from("units"), AttributeValue::Text(Text::from("metres")));
        let layers = [
            Layer::new((2, 1), attributes, Encoding::FAST_LOSSLESS, first),
            Layer::new((1, 1), LayerAttributes::named("shadow"), Encoding::FAST_LOSSLESS, second),
        ];
        let image: Image<Layers<AnyChannels<FlatSamples>>> = Image::from_layers(
            ImageAttributes::new(IntegerBounds::from_dimensions((2, 1))),
            Layers::from(layers.to_vec()),
        );
        image.write().to_file(&path).unwrap();

        let file = ExrFile::read(&path);
        assert_eq!(
            file.parts.iter().map(|p| (&p.name[..], p.size)).collect::<Vec<_>>(),
            [("picture", [2, 1]), ("shadow", [1, 1])]
        );
        let part = file.part("picture");
        assert_eq!(part.channel("R"), &Channel::Half(vec![0.5, 2.0]));
        assert_eq!(part.floats("Z"), [1.25, f32::INFINITY]);
        assert_eq!(part.uints("id.object"), [7, u32::MAX]);
        assert_eq!(part.texts["units"], "metres");
        assert_eq!(file.part("shadow").floats("depth"), [3.0]);
    }
}
