//! What a SPIR-V module wants bound, read from the module itself.

use spirq::prelude::*;
use spirq::ty::{DescriptorType, Type};
use spirq::var::Variable;

/// What a kernel is bound to and how large its workgroups are.
#[derive(Debug, Clone, PartialEq)]
pub struct Interface {
    /// In the order of set and binding.
    pub slots: Vec<Slot>,
    /// Bytes of push constants; 0 for none.
    pub push_constants: u32,
    /// Invocations along each axis; ones for stages that are not compute.
    pub workgroup: [u32; 3],
    /// Numbers of the SPIR-V capabilities it declares.
    pub capabilities: Vec<u32>,
    /// Every named struct in a buffer or in the push constants, with its layout.
    pub structs: Vec<Struct>,
}

/// One descriptor.
#[derive(Debug, Clone, PartialEq)]
pub struct Slot {
    pub set: u32,
    pub binding: u32,
    pub kind: SlotKind,
    /// The block's name (`Vertices`), or the variable's where there is no block.
    pub name: String,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SlotKind {
    StorageBuffer,
    StorageImage,
    AccelerationStructure,
}

/// A struct as the SPIR-V lays it out.
#[derive(Debug, Clone, PartialEq)]
pub struct Struct {
    pub name: String,
    /// (name, offset in bytes, size in bytes).
    pub fields: Vec<(String, usize, usize)>,
    /// Bytes from one element to the next where the struct is the element of an array.
    pub stride: Option<usize>,
}

/// Reads the interface of the module's only entry point. The error is a reason.
pub fn reflect(words: &[u32]) -> Result<Interface, String> {
    // Where all of its accesses are of these, spirq takes a resource for unused and leaves it out.
    let unseen = instructions(words).any(|(op, _)| matches!(op, OP_IMAGE_TEXEL_POINTER | OP_ATOMIC_F_ADD));
    let entry_points = ReflectConfig::new()
        .spv(words.to_vec())
        .ref_all_rscs(unseen)
        .reflect()
        .map_err(|e| format!("its SPIR-V cannot be read: {e}"))?;
    let [entry] = entry_points.as_slice() else {
        return Err(format!("it has {} entry points instead of one", entry_points.len()));
    };
    let mut interface = Interface {
        slots: vec![],
        push_constants: 0,
        workgroup: [1; 3],
        capabilities: capabilities(words),
        structs: vec![],
    };
    for variable in &entry.vars {
        match variable {
            Variable::Descriptor { name, desc_bind, desc_ty, ty, .. } => {
                collect_structs(ty, None, &mut interface.structs);
                interface.slots.push(Slot {
                    set: desc_bind.set(),
                    binding: desc_bind.bind(),
                    kind: slot_kind(desc_ty)?,
                    name: block_name(ty).or(name.as_deref()).unwrap_or("").to_string(),
                });
            }
            Variable::PushConstant { ty, .. } => {
                collect_structs(ty, None, &mut interface.structs);
                interface.push_constants = ty.nbyte().unwrap_or(0).next_multiple_of(4) as u32;
            }
            _ => {}
        }
    }
    for mode in &entry.exec_modes {
        if mode.exec_mode == spirq::spirv::ExecutionMode::LocalSize {
            for (axis, operand) in interface.workgroup.iter_mut().zip(&mode.operands) {
                *axis = literal(&operand.value).ok_or("its workgroup size is not a literal")?;
            }
        }
    }
    interface.slots.sort_by_key(|slot| (slot.set, slot.binding));
    Ok(interface)
}

/// Ids and names of the module's specialization constants.
pub fn constants(words: &[u32]) -> Vec<(u32, String)> {
    let of = |wanted| instructions(words).filter(move |(op, _)| *op == wanted).map(|(_, operands)| operands);
    let name =
        |target| of(OP_NAME).find(|operands| operands.first() == Some(&target)).map(|operands| text(&operands[1..]));
    let constant = |operands: &[u32]| match *operands {
        [target, SPEC_ID, id, ..] => Some((id, name(target).unwrap_or_default())),
        _ => None,
    };
    of(OP_DECORATE).filter_map(constant).collect()
}

/// The literal string that begins there.
fn text(words: &[u32]) -> String {
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).take_while(|byte| *byte != 0).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

const OP_CAPABILITY: u32 = 17;
const OP_NAME: u32 = 5;
const OP_DECORATE: u32 = 71;
const SPEC_ID: u32 = 1;
const OP_IMAGE_TEXEL_POINTER: u32 = 60;
const OP_ATOMIC_F_ADD: u32 = 6035;

/// The number and the operands of every instruction.
fn instructions(words: &[u32]) -> impl Iterator<Item = (u32, &[u32])> {
    const HEADER_WORDS: usize = 5;
    let mut rest = words.get(HEADER_WORDS..).unwrap_or_default();
    std::iter::from_fn(move || {
        let first = *rest.first()?;
        let (instruction, after) = rest.split_at(((first >> 16).max(1) as usize).min(rest.len()));
        rest = after;
        Some((first & 0xffff, &instruction[1..]))
    })
}

/// The operands of every OpCapability.
fn capabilities(words: &[u32]) -> Vec<u32> {
    instructions(words)
        .filter(|(op, _)| *op == OP_CAPABILITY)
        .filter_map(|(_, operands)| operands.first().copied())
        .collect()
}

fn literal(value: &spirq::constant::ConstantValue) -> Option<u32> {
    use spirq::constant::ConstantValue;
    match value {
        ConstantValue::U32(value) => Some(*value),
        ConstantValue::S32(value) => u32::try_from(*value).ok(),
        ConstantValue::Typeless(bytes) => Some(u32::from_le_bytes(bytes.get(..4)?.try_into().ok()?)),
        _ => None,
    }
}

fn slot_kind(kind: &DescriptorType) -> Result<SlotKind, String> {
    match kind {
        DescriptorType::StorageBuffer(_) => Ok(SlotKind::StorageBuffer),
        DescriptorType::StorageImage(_) => Ok(SlotKind::StorageImage),
        DescriptorType::AccelStruct() => Ok(SlotKind::AccelerationStructure),
        other => Err(format!(
            "it wants a descriptor of kind {other:?}; storage buffers, storage images and acceleration structures are \
             offered"
        )),
    }
}

fn block_name(ty: &Type) -> Option<&str> {
    match ty {
        Type::Struct(block) => block.name(),
        _ => None,
    }
}

fn collect_structs(ty: &Type, stride: Option<usize>, found: &mut Vec<Struct>) {
    match ty {
        Type::Struct(block) => {
            let fields = block.members.iter().map(|m| {
                (m.name.clone().unwrap_or_default(), m.offset.unwrap_or(usize::MAX), m.ty.nbyte().unwrap_or(0))
            });
            found.push(Struct { name: block.name().unwrap_or("").to_string(), fields: fields.collect(), stride });
            block.members.iter().for_each(|m| collect_structs(&m.ty, None, found));
        }
        Type::Array(array) => collect_structs(&array.element_ty, array.stride, found),
        _ => {}
    }
}
