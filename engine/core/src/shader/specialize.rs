//! Specialisation on the host: a shader's specialisation constants, and what is computed from them, become plain
//! constants. Drivers take them as they are, too, but SwiftShader's optimiser then removes no branch that they rule out
//! and unrolls no loop whose end they say.

use rustc_hash::{FxHashMap, FxHashSet};

/// Words before the first instruction.
const HEADER: usize = 5;

/// Heads of instructions, with their length in words (SPIR-V 1.6, section 3.49).
mod head {
    pub const TYPE_BOOL: u32 = 2 << 16 | 20;
    pub const TYPE_INT: u32 = 4 << 16 | 21;
    pub const TYPE_FLOAT: u32 = 3 << 16 | 22;
    pub const TRUE: u32 = 3 << 16 | 41;
    pub const FALSE: u32 = 3 << 16 | 42;
    pub const CONSTANT: u32 = 4 << 16 | 43;
    pub const SPEC_TRUE: u32 = 3 << 16 | 48;
    pub const SPEC_FALSE: u32 = 3 << 16 | 49;
    pub const SPEC_CONSTANT: u32 = 4 << 16 | 50;
    pub const DECORATE: u32 = 4 << 16 | 71;
}
const COMPOSITE: u32 = 44;
const SPEC_COMPOSITE: u32 = 51;
const SPEC_OPERATION: u32 = 52;
/// Decoration of a specialisation constant.
const SPEC_ID: u32 = 1;

/// The module with these values of its specialisation constants, by `constant_id`, and the defaults of all others.
/// Bools are 0 or 1. An operation that is not known here stays for the driver.
pub(crate) fn specialized(words: &[u32], values: &[(u32, u32)]) -> Vec<u32> {
    let (header, mut rest) = words.split_at(HEADER.min(words.len()));
    let mut module = Module { words: header.to_vec(), ..Module::default() };
    while let Some(head) = rest.first() {
        let length = ((head >> 16) as usize).clamp(1, rest.len());
        let (instruction, tail) = rest.split_at(length);
        module.push(instruction, values);
        rest = tail;
    }
    module.words
}

/// What was put out so far.
#[derive(Default)]
struct Module {
    words: Vec<u32>,
    bool_type: u32,
    /// Of 32 bits.
    number_types: FxHashSet<u32>,
    /// Values that are asked for, by id.
    asked: FxHashMap<u32, u32>,
    /// Constants by id: bools, and numbers of 32 bits.
    known: FxHashMap<u32, u32>,
    /// What stays a specialisation constant.
    left: FxHashSet<u32>,
}

impl Module {
    fn push(&mut self, instruction: &[u32], values: &[(u32, u32)]) {
        match *instruction {
            [head::DECORATE, id, SPEC_ID, constant] => {
                let value = values.iter().find(|value| value.0 == constant);
                self.asked.extend(value.map(|value| (id, value.1)));
                return;
            }
            [head::TRUE | head::SPEC_TRUE, ty, id] => return self.constant(ty, id, 1),
            [head::FALSE | head::SPEC_FALSE, ty, id] => return self.constant(ty, id, 0),
            [head::CONSTANT | head::SPEC_CONSTANT, ty, id, value] => return self.constant(ty, id, value),
            [head::TYPE_BOOL, id] => self.bool_type = id,
            [head::TYPE_INT, id, 32, _] | [head::TYPE_FLOAT, id, 32] => drop(self.number_types.insert(id)),
            [head, ty, id, operation, ref operands @ ..] if head & 0xffff == SPEC_OPERATION => {
                match self.operation(operation, operands).filter(|_| self.is_scalar(ty)) {
                    Some(value) => return self.constant(ty, id, value),
                    None => drop(self.left.insert(id)),
                }
            }
            [head, _, id, ref parts @ ..] if head & 0xffff == SPEC_COMPOSITE => {
                if parts.iter().any(|part| self.left.contains(part)) {
                    self.left.insert(id);
                } else {
                    self.words.push(head & 0xffff_0000 | COMPOSITE);
                    return self.words.extend(&instruction[1..]);
                }
            }
            _ => {}
        }
        self.words.extend(instruction);
    }

    fn is_scalar(&self, ty: u32) -> bool {
        ty == self.bool_type || self.number_types.contains(&ty)
    }

    /// A constant of its default, or of what is asked for.
    fn constant(&mut self, ty: u32, id: u32, default: u32) {
        let value = self.asked.get(&id).copied().unwrap_or(default);
        if ty == self.bool_type {
            self.words.extend([if value != 0 { head::TRUE } else { head::FALSE }, ty, id]);
        } else {
            self.words.extend([head::CONSTANT, ty, id, value]);
        }
        if self.is_scalar(ty) {
            self.known.insert(id, value);
        }
    }

    /// The value of an operation on known constants.
    fn operation(&self, operation: u32, operands: &[u32]) -> Option<u32> {
        let known = |id: &u32| self.known.get(id).copied();
        Some(match (operation, operands) {
            (168, [a]) => u32::from(known(a)? == 0), // LogicalNot
            (169, [if_so, a, b]) => known(if known(if_so)? != 0 { a } else { b })?, // Select
            (_, [a, b]) => {
                let (a, b) = (known(a)?, known(b)?);
                match operation {
                    128 => a.wrapping_add(b),              // IAdd
                    130 => a.wrapping_sub(b),              // ISub
                    132 => a.wrapping_mul(b),              // IMul
                    164 | 170 => (a == b).into(),          // LogicalEqual, IEqual
                    165 | 171 => (a != b).into(),          // LogicalNotEqual, INotEqual
                    166 | 197 => a | b,                    // LogicalOr, BitwiseOr
                    167 | 199 => a & b,                    // LogicalAnd, BitwiseAnd
                    172 => (a > b).into(),                 // UGreaterThan
                    173 => (a as i32 > b as i32).into(),   // SGreaterThan
                    174 => (a >= b).into(),                // UGreaterThanEqual
                    175 => (a as i32 >= b as i32).into(),  // SGreaterThanEqual
                    176 => (a < b).into(),                 // ULessThan
                    177 => ((a as i32) < b as i32).into(), // SLessThan
                    178 => (a <= b).into(),                // ULessThanEqual
                    179 => (a as i32 <= b as i32).into(),  // SLessThanEqual
                    _ => return None,
                }
            }
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOOL: u32 = 1;
    const UINT: u32 = 2;

    /// A module of these instructions, after types of bools and of numbers of 32 bits.
    fn module(instructions: &[&[u32]]) -> Vec<u32> {
        let header: &[u32] = &[0x0723_0203, 0x0001_0600, 0, 99, 0];
        let before = [header, &[head::TYPE_BOOL, BOOL], &[head::TYPE_INT, UINT, 32, 0]];
        [&before, instructions].concat().concat()
    }

    #[test]
    fn constants_take_the_value_that_is_asked_for_or_their_default() {
        let named = module(&[
            &[head::DECORATE, 10, SPEC_ID, 3],
            &[head::DECORATE, 11, SPEC_ID, 4],
            &[head::DECORATE, 12, SPEC_ID, 5],
            &[head::SPEC_CONSTANT, UINT, 10, 7],
            &[head::SPEC_CONSTANT, UINT, 11, 8],
            &[head::SPEC_TRUE, BOOL, 12],
        ]);
        let plain =
            module(&[&[head::CONSTANT, UINT, 10, 20], &[head::CONSTANT, UINT, 11, 8], &[head::FALSE, BOOL, 12]]);
        assert_eq!(specialized(&named, &[(3, 20), (5, 0), (9, 1)]), plain);
    }

    #[test]
    fn what_is_computed_from_them_becomes_a_constant() {
        let operation = |length: u32| (4 + length) << 16 | SPEC_OPERATION;
        let (equal, not, select, subtract, shift) = (170, 168, 169, 130, 194);
        let computed = module(&[
            &[head::DECORATE, 10, SPEC_ID, 0],
            &[head::SPEC_CONSTANT, UINT, 10, 7],
            &[head::CONSTANT, UINT, 11, 5],
            &[operation(2), BOOL, 12, equal, 10, 11],
            &[operation(1), BOOL, 13, not, 12],
            &[operation(3), UINT, 14, select, 13, 10, 11],
            &[operation(2), UINT, 15, subtract, 11, 14],
            &[operation(2), UINT, 16, shift, 10, 11],
            &[5 << 16 | SPEC_COMPOSITE, 50, 17, 10, 15],
            &[5 << 16 | SPEC_COMPOSITE, 50, 18, 10, 16],
        ]);
        let plain = module(&[
            &[head::CONSTANT, UINT, 10, 9],
            &[head::CONSTANT, UINT, 11, 5],
            &[head::FALSE, BOOL, 12],
            &[head::TRUE, BOOL, 13],
            &[head::CONSTANT, UINT, 14, 9],
            &[head::CONSTANT, UINT, 15, 4u32.wrapping_neg()],
            // Not known here: the driver's.
            &[operation(2), UINT, 16, shift, 10, 11],
            &[5 << 16 | COMPOSITE, 50, 17, 10, 15],
            &[5 << 16 | SPEC_COMPOSITE, 50, 18, 10, 16],
        ]);
        assert_eq!(specialized(&computed, &[(0, 9)]), plain);
    }
}
