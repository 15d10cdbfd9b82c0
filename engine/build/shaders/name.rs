//! Names of GLSL as names of Rust.

/// `shadowMap`, `Frame`, `lights_2d` as `SHADOW_MAP`, `FRAME`, `LIGHTS_2D`.
pub fn constant(name: &str) -> String {
    let characters: Vec<char> = name.chars().collect();
    let mut result = String::new();
    for (i, &c) in characters.iter().enumerate() {
        let after_small = i > 0 && (characters[i - 1].is_lowercase() || characters[i - 1].is_numeric());
        let before_small =
            i > 0 && characters[i - 1].is_uppercase() && characters.get(i + 1).is_some_and(|next| next.is_lowercase());
        if c.is_uppercase() && (after_small || before_small) {
            result.push('_');
        }
        result.extend(c.to_uppercase());
    }
    result
}

/// A folder's or a file's name as a module's: what is no letter or digit turns into `_`.
pub fn module(name: &str) -> String {
    let mut result: String = name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect();
    if result.starts_with(|c: char| c.is_numeric()) {
        result.insert(0, '_');
    }
    identifier(&result)
}

/// A name that may be a Rust keyword.
pub fn identifier(name: &str) -> String {
    match name {
        "self" | "Self" | "super" | "crate" | "_" => format!("{name}_"),
        _ if KEYWORDS.contains(&name) => format!("r#{name}"),
        _ => name.to_owned(),
    }
}

/// Strict and reserved keywords of Rust 2024.
const KEYWORDS: &[&str] = &[
    "abstract", "as", "async", "await", "become", "box", "break", "const", "continue", "do", "dyn", "else", "enum",
    "extern", "false", "final", "fn", "for", "gen", "if", "impl", "in", "let", "loop", "macro", "match", "mod", "move",
    "mut", "override", "priv", "pub", "ref", "return", "static", "struct", "trait", "true", "try", "type", "typeof",
    "unsafe", "unsized", "use", "virtual", "where", "while", "yield",
];

/// SPIR-V's name of a storage image's format (`Rgba16f`, `R32ui`, `Rg8Snorm`) as the variant of `vk::Format`; `None`
/// where the shader names none.
pub fn format(spirv: &str) -> Option<String> {
    let packed = match spirv {
        "R11fG11fB10f" => Some("B10G11R11_UFLOAT_PACK32"),
        "Rgb10A2" => Some("A2B10G10R10_UNORM_PACK32"),
        "Rgb10a2ui" => Some("A2B10G10R10_UINT_PACK32"),
        _ => None,
    };
    if let Some(packed) = packed {
        return Some(packed.into());
    }
    let digits = spirv.find(|c: char| c.is_ascii_digit())?;
    let (channels, rest) = spirv.split_at(digits);
    let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
    let (bits, suffix) = rest.split_at(end);
    let kind = match suffix {
        "" => "UNORM",
        "Snorm" => "SNORM",
        "f" => "SFLOAT",
        "ui" => "UINT",
        "i" => "SINT",
        _ => return None,
    };
    let channels: String = channels.chars().map(|channel| format!("{}{bits}", channel.to_uppercase())).collect();
    Some(format!("{channels}_{kind}"))
}
