//! Blocks and structs of shaders as Rust structs with the same offsets.

use std::collections::BTreeMap;

use spirq::ty::{ArrayType, MatrixAxisOrder, ScalarType, SpirvType, StructType, Type as Reflected};

use super::{name, words};
use crate::source::ROOT;

/// A type in a block.
#[derive(Clone, Debug, PartialEq)]
pub enum Type {
    /// One number.
    Scalar(Scalar),
    /// Two to four.
    Vector(Scalar, u32),
    /// Columns, rows; by columns.
    Matrix(Scalar, u32, u32),
    /// Element, length.
    Array(Box<Type>, u32),
    /// Name, size and alignment of a struct of [`Blocks`].
    Struct(String, u32, u32),
}

/// A number: its Rust type, its GLSL name and prefix of vectors, its bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scalar {
    rust: &'static str,
    glsl: &'static str,
    prefix: &'static str,
    bytes: u32,
}

/// A member.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// As in the shader.
    pub name: String,
    /// Bytes from the start of the block.
    pub offset: u32,
    /// Its type.
    pub ty: Type,
}

/// A block or struct.
#[derive(Clone, Debug)]
pub struct Block {
    /// Members, by offset.
    pub fields: Vec<Field>,
    /// Bytes, with what the alignment adds at the end.
    pub size: u32,
    /// Shader that has it, for messages.
    pub file: String,
}

/// Every block and struct, by name.
#[derive(Default)]
pub struct Blocks {
    /// Each is one Rust type.
    pub by_name: BTreeMap<String, Block>,
}

/// What a block holds.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// A fixed part, or the element of a block that is but a run-time array.
    One(Type),
    /// A fixed part, then a run-time array.
    Tail {
        /// The fixed part.
        head: Type,
        /// The array's element.
        element: Type,
    },
}

impl Blocks {
    /// Takes in the block `ty` of the shader `file`. Gives its content and the bytes of its fixed part.
    pub fn add(&mut self, ty: &StructType, file: &str) -> Result<(Content, u32), String> {
        let name = block_name(ty)?;
        let Some((last, fixed)) = ty.members.split_last() else {
            return Err(format!("block {name} is empty"));
        };
        let Reflected::Array(array @ ArrayType { nelement: None, .. }) = &last.ty else {
            let head = self.add_struct(ty, ty.members.len(), None, file)?;
            let size = ty.nbyte().unwrap_or_default() as u32;
            return Ok((Content::One(head), size));
        };
        let place = format!("block {name}, member {}", last.name.as_deref().unwrap_or("?"));
        let element = self.convert(&array.element_ty, file, &place)?;
        check_stride(&place, array.stride, &element)?;
        let offset = last.offset.unwrap_or_default() as u32;
        if fixed.is_empty() {
            return Ok((Content::One(element), offset));
        }
        let head = self.add_struct(ty, fixed.len(), Some(offset), file)?;
        Ok((Content::Tail { head, element }, offset))
    }

    /// The first `count` members of `ty` as a struct of the size `size`, where that is given.
    fn add_struct(&mut self, ty: &StructType, count: usize, size: Option<u32>, file: &str) -> Result<Type, String> {
        let name = block_name(ty)?;
        let mut fields = Vec::new();
        for (index, member) in ty.members[..count].iter().enumerate() {
            let member_name = member.name.clone().unwrap_or_else(|| format!("member_{index}"));
            let place = format!("block {name}, member {member_name}");
            let offset = member.offset.ok_or_else(|| format!("{place} has no offset"))? as u32;
            fields.push(Field { name: member_name, offset, ty: self.convert(&member.ty, file, &place)? });
        }
        fields.sort_by_key(|field| field.offset);
        for pair in fields.windows(2) {
            if pair[0].offset + pair[0].ty.size() > pair[1].offset {
                return Err(format!(
                    "block {name}, member {}: lies in the padding at the end of {}, which Rust cannot say; reorder them",
                    pair[1].name, pair[0].name
                ));
            }
        }
        let align = fields.iter().map(|field| field.ty.align()).max().unwrap_or(1);
        if let Some(field) = fields.iter().find(|field| field.offset % field.ty.align() != 0) {
            return Err(format!("block {name}, member {}: not aligned: say layout(scalar, …)", field.name));
        }
        let end = fields.last().map_or(0, |field| field.offset + field.ty.size());
        let size = size.unwrap_or(end).next_multiple_of(align);
        let block = Block { fields, size, file: file.to_owned() };
        match self.by_name.get(name) {
            None => drop(self.by_name.insert(name.to_owned(), block)),
            Some(other) => other.must_equal(&block, name)?,
        }
        Ok(Type::Struct(name.to_owned(), size, align))
    }

    fn convert(&mut self, ty: &Reflected, file: &str, place: &str) -> Result<Type, String> {
        match ty {
            Reflected::Scalar(scalar) => Ok(Type::Scalar(Scalar::new(scalar, place)?)),
            Reflected::Vector(vector) => Ok(Type::Vector(Scalar::new(&vector.scalar_ty, place)?, vector.nscalar)),
            Reflected::Matrix(matrix) => {
                let scalar = Scalar::new(&matrix.vector_ty.scalar_ty, place)?;
                let column = Type::Vector(scalar, matrix.vector_ty.nscalar);
                if matrix.axis_order == Some(MatrixAxisOrder::RowMajor) {
                    return Err(format!("{place}: row_major is not supported"));
                }
                check_stride(place, matrix.stride, &column)?;
                Ok(Type::Matrix(scalar, matrix.nvector, matrix.vector_ty.nscalar))
            }
            Reflected::Array(array) => {
                let element = self.convert(&array.element_ty, file, place)?;
                check_stride(place, array.stride, &element)?;
                let length = array.nelement.ok_or_else(|| format!("{place}: a run-time array must come last"))?;
                if length == words::SPECIALIZED {
                    return Err(format!("{place} is as long as a specialization constant says: layouts need a number"));
                }
                Ok(Type::Array(Box::new(element), length))
            }
            Reflected::Struct(ty) => self.add_struct(ty, ty.members.len(), None, file),
            Reflected::DevicePointer(_) | Reflected::DeviceAddress(_) => Ok(Type::Scalar(ADDRESS)),
            other => Err(format!("{place}: a {other} cannot be in a block")),
        }
    }
}

impl Block {
    /// Two blocks of one name must be one.
    fn must_equal(&self, other: &Block, name: &str) -> Result<(), String> {
        if self.fields == other.fields && self.size == other.size {
            return Ok(());
        }
        let show = |field: Option<&Field>| {
            field.map_or("nothing".into(), |field| format!("{} {} at {}", field.ty.glsl(), field.name, field.offset))
        };
        let differing =
            (0..).find(|&i| self.fields.get(i) != other.fields.get(i) || i >= self.fields.len()).unwrap_or(0);
        let difference = if self.fields == other.fields {
            format!("{} against {} bytes", other.size, self.size)
        } else {
            format!("{}, against {}", show(other.fields.get(differing)), show(self.fields.get(differing)))
        };
        Err(format!(
            "block {name} differs from that of {ROOT}/{}: {difference}; rename one, or put it in an include",
            self.file
        ))
    }
}

impl Type {
    /// Bytes.
    pub fn size(&self) -> u32 {
        match self {
            Self::Scalar(scalar) => scalar.bytes,
            Self::Vector(scalar, length) => scalar.bytes * length,
            Self::Matrix(scalar, columns, rows) => scalar.bytes * columns * rows,
            Self::Array(element, length) => element.size() * length,
            Self::Struct(_, size, _) => *size,
        }
    }

    /// Bytes, as scalar layout and `#[repr(C)]` have it.
    pub fn align(&self) -> u32 {
        match self {
            Self::Scalar(scalar) | Self::Vector(scalar, _) | Self::Matrix(scalar, ..) => scalar.bytes,
            Self::Array(element, _) => element.align(),
            Self::Struct(_, _, align) => *align,
        }
    }

    /// The Rust type; structs are looked up in the module `blocks`.
    pub fn rust(&self, blocks: &str) -> String {
        match self {
            Self::Scalar(scalar) => scalar.rust.into(),
            Self::Vector(scalar, length @ (2 | 3)) if scalar.rust == "f32" => format!("::glam::Vec{length}"),
            Self::Vector(scalar, length) => format!("[{}; {length}]", scalar.rust),
            Self::Matrix(scalar, columns, rows) => format!("[[{}; {rows}]; {columns}]", scalar.rust),
            Self::Array(element, length) => format!("[{}; {length}]", element.rust(blocks)),
            Self::Struct(name, ..) => format!("{blocks}{}", name::identifier(name)),
        }
    }

    /// The GLSL type.
    pub fn glsl(&self) -> String {
        match self {
            Self::Scalar(scalar) => scalar.glsl.into(),
            Self::Vector(scalar, length) => format!("{}vec{length}", scalar.prefix),
            Self::Matrix(scalar, columns, rows) if columns == rows => format!("{}mat{columns}", scalar.prefix),
            Self::Matrix(scalar, columns, rows) => format!("{}mat{columns}x{rows}", scalar.prefix),
            Self::Array(element, length) => {
                // GLSL puts the outer length first.
                let (inner, lengths) = match element.glsl().split_once('[') {
                    Some((inner, lengths)) => (inner.to_owned(), format!("[{lengths}")),
                    None => (element.glsl(), String::new()),
                };
                format!("{inner}[{length}]{lengths}")
            }
            Self::Struct(name, ..) => name.clone(),
        }
    }
}

const ADDRESS: Scalar = Scalar { rust: "u64", glsl: "device address", prefix: "", bytes: 8 };

impl Scalar {
    fn new(ty: &ScalarType, place: &str) -> Result<Self, String> {
        let (rust, glsl, prefix, bytes) = match ty {
            ScalarType::Float { bits: 32 } => ("f32", "float", "", 4),
            ScalarType::Float { bits: 64 } => ("f64", "double", "d", 8),
            // Its bits: `half` is no dependency of generated code.
            ScalarType::Float { bits: 16 } => ("u16", "float16_t", "f16", 2),
            ScalarType::Integer { bits: 32, is_signed: true } => ("i32", "int", "i", 4),
            ScalarType::Integer { bits: 32, is_signed: false } => ("u32", "uint", "u", 4),
            ScalarType::Integer { bits: 64, is_signed: true } => ("i64", "int64_t", "i64", 8),
            ScalarType::Integer { bits: 64, is_signed: false } => ("u64", "uint64_t", "u64", 8),
            ScalarType::Integer { bits: 16, is_signed: true } => ("i16", "int16_t", "i16", 2),
            ScalarType::Integer { bits: 16, is_signed: false } => ("u16", "uint16_t", "u16", 2),
            ScalarType::Integer { bits: 8, is_signed: true } => ("i8", "int8_t", "i8", 1),
            ScalarType::Integer { bits: 8, is_signed: false } => ("u8", "uint8_t", "u8", 1),
            other => return Err(format!("{place}: no Rust type for {other}")),
        };
        Ok(Self { rust, glsl, prefix, bytes })
    }
}

fn block_name(ty: &StructType) -> Result<&str, String> {
    ty.name().ok_or_else(|| "a block without a name".into())
}

/// Elements of arrays and columns of matrices lie without gaps in scalar layout, and in Rust always.
fn check_stride(place: &str, stride: Option<usize>, element: &Type) -> Result<(), String> {
    match stride {
        Some(stride) if stride as u32 != element.size() => Err(format!(
            "{place}: elements are {stride} bytes apart, which scalar layout would have {} apart: say layout(scalar, …)",
            element.size()
        )),
        _ => Ok(()),
    }
}
