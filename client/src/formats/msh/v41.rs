//! Sections of MSH 4.1: nodes and elements in blocks by geometric entity,
//! which carries the physical groups.

use std::collections::HashMap;

use super::cursor::Cursor;
use super::error::{Fault, MshError};
use super::kind::{kind, reorder};
use crate::formats::mesh::raw::{Block, Owner};

/// The entity section: physical groups by dimension and entity number.
pub(super) fn entities(
    cursor: &mut Cursor<'_>,
) -> Result<HashMap<(usize, i64), Vec<i64>>, MshError> {
    let what = "the number of entities";
    let mut counts = [0; 4];
    for count in &mut counts {
        *count = cursor.size(what)?;
    }
    let mut entities = HashMap::new();
    for (dimension, declared) in counts.into_iter().enumerate() {
        for _ in 0..cursor.bounded(what, declared, 5)? {
            let tag = cursor.integer("an entity number")?;
            entities.insert((dimension, tag), entity(cursor, dimension)?);
        }
    }
    Ok(entities)
}

/// Physical groups of one entity; its box and bounding entities are not needed.
fn entity(cursor: &mut Cursor<'_>, dimension: usize) -> Result<Vec<i64>, MshError> {
    cursor.point()?;
    if dimension > 0 {
        cursor.point()?;
    }
    let groups = tags(cursor, "the number of physical groups")?;
    if dimension > 0 {
        tags(cursor, "the number of bounding entities")?;
    }
    let groups = groups.into_iter();
    groups.map(|tag| cursor.group_number(tag)).collect()
}

fn tags(cursor: &mut Cursor<'_>, what: &'static str) -> Result<Vec<i64>, MshError> {
    let declared = cursor.size(what)?;
    let count = cursor.bounded(what, declared, 1)?;
    (0..count).map(|_| cursor.integer("a tag")).collect()
}

/// Counts at the head of the node and the element section.
struct Head {
    blocks: usize,
    items: u64,
}

fn head(cursor: &mut Cursor<'_>, what: &'static str) -> Result<Head, MshError> {
    let blocks = cursor.size("the number of blocks")?;
    let items = cursor.size(what)?;
    cursor.size("the smallest number")?;
    cursor.size("the largest number")?;
    cursor.bounded(what, items, 2)?;
    let blocks = cursor.bounded("the number of blocks", blocks, 4)?;
    Ok(Head { blocks, items })
}

fn agree(
    cursor: &Cursor<'_>,
    what: &'static str,
    declared: u64,
    found: usize,
) -> Result<(), MshError> {
    let found = found as u64;
    if declared == found {
        return Ok(());
    }
    Err(cursor.error(Fault::Inconsistent {
        what,
        declared,
        found,
    }))
}

/// The node section: number and coordinates of each.
pub(super) fn nodes(cursor: &mut Cursor<'_>) -> Result<Vec<(u64, [f64; 3])>, MshError> {
    let what = "the number of nodes";
    let head = head(cursor, what)?;
    let mut nodes = Vec::new();
    for _ in 0..head.blocks {
        node_block(cursor, &mut nodes)?;
    }
    agree(cursor, what, head.items, nodes.len())?;
    Ok(nodes)
}

fn node_block(cursor: &mut Cursor<'_>, nodes: &mut Vec<(u64, [f64; 3])>) -> Result<(), MshError> {
    let dimension = cursor.natural("an entity dimension")?;
    cursor.integer("an entity number")?;
    let parametric = cursor.integer("the parametric flag")?;
    let declared = cursor.size("the number of nodes in a block")?;
    let count = cursor.bounded("the number of nodes in a block", declared, 4)?;
    let parameters = if parametric == 0 { 0 } else { dimension.min(3) };
    let mut tags = Vec::with_capacity(count);
    for _ in 0..count {
        tags.push(cursor.size("a node number")?);
    }
    for tag in tags {
        nodes.push((tag, cursor.point()?));
        for _ in 0..parameters {
            cursor.real("a parameter")?;
        }
    }
    Ok(())
}

/// The element section.
pub(super) fn elements(cursor: &mut Cursor<'_>) -> Result<Vec<Block>, MshError> {
    let what = "the number of elements";
    let head = head(cursor, what)?;
    let mut blocks = Vec::new();
    let mut found = 0;
    for _ in 0..head.blocks {
        let block = element_block(cursor)?;
        found += block.nodes.len() / block.kind.nodes;
        blocks.push(block);
    }
    agree(cursor, what, head.items, found)?;
    Ok(blocks)
}

fn element_block(cursor: &mut Cursor<'_>) -> Result<Block, MshError> {
    cursor.integer("an entity dimension")?;
    let owner = Owner::Entity(cursor.integer("an entity number")?);
    let number = cursor.integer("an element type")?;
    let kind = kind(number).map_err(|fault| cursor.error(fault))?;
    let what = "the number of elements in a block";
    let declared = cursor.size(what)?;
    let count = cursor.bounded(what, declared, 1 + kind.nodes)?;
    let mut nodes = Vec::with_capacity(count * kind.nodes);
    for _ in 0..count {
        cursor.size("an element number")?;
        for _ in 0..kind.nodes {
            nodes.push(cursor.size("a node number")?);
        }
    }
    reorder(kind, &mut nodes);
    Ok(Block { kind, owner, nodes })
}
