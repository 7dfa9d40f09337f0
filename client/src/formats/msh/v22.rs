//! Sections of MSH 2.2: nodes and elements carry 32-bit numbers, elements
//! carry their physical group as first tag.

use super::cursor::{Cursor, Encoding};
use super::error::{Fault, MshError};
use super::kind::{kind as kind_of, reorder};
use crate::formats::mesh::raw::{Block, ElementKind, Owner};

/// The node section: number and coordinates of each.
pub(super) fn nodes(cursor: &mut Cursor<'_>) -> Result<Vec<(u64, [f64; 3])>, MshError> {
    let declared = count(cursor, "the number of nodes")?;
    let count = cursor.bounded("the number of nodes", declared, 4)?;
    let mut nodes = Vec::with_capacity(count);
    for _ in 0..count {
        nodes.push((cursor.natural("a node number")?, cursor.point()?));
    }
    Ok(nodes)
}

/// The element section.
pub(super) fn elements(cursor: &mut Cursor<'_>) -> Result<Vec<Block>, MshError> {
    let declared = count(cursor, "the number of elements")?;
    let count = cursor.bounded("the number of elements", declared, 3)?;
    let mut blocks = Vec::new();
    match cursor.encoding() {
        Encoding::Text => text_elements(cursor, count, &mut blocks)?,
        Encoding::Binary => binary_elements(cursor, count, &mut blocks)?,
    }
    Ok(blocks)
}

/// Counts of sections are text in both encodings, on a line of their own.
fn count(cursor: &mut Cursor<'_>, what: &'static str) -> Result<u64, MshError> {
    let declared = cursor.text_integer(what)?;
    if cursor.encoding() == Encoding::Binary {
        cursor.end_line();
    }
    u64::try_from(declared).map_err(|_| {
        let found = declared.to_string();
        cursor.error(Fault::Unexpected {
            expected: what,
            found,
        })
    })
}

fn text_elements(
    cursor: &mut Cursor<'_>,
    count: usize,
    blocks: &mut Vec<Block>,
) -> Result<(), MshError> {
    for _ in 0..count {
        cursor.integer("an element number")?;
        let kind = kind(cursor)?;
        let tags = tag_count(cursor)?;
        element(cursor, kind, tags, blocks)?;
    }
    Ok(())
}

fn binary_elements(
    cursor: &mut Cursor<'_>,
    count: usize,
    blocks: &mut Vec<Block>,
) -> Result<(), MshError> {
    let mut found = 0_usize;
    while found < count {
        let kind = kind(cursor)?;
        let declared = cursor.natural("the number of elements of one type")?;
        let following = cursor.bounded("the number of elements of one type", declared, 1)?;
        let tags = tag_count(cursor)?;
        for _ in 0..following {
            cursor.integer("an element number")?;
            element(cursor, kind, tags, blocks)?;
        }
        // An empty run would never come to an end.
        found += following.max(1);
    }
    if found == count {
        return Ok(());
    }
    let what = "the number of elements";
    let (declared, found) = (count as u64, found as u64);
    Err(cursor.error(Fault::Inconsistent {
        what,
        declared,
        found,
    }))
}

fn kind(cursor: &mut Cursor<'_>) -> Result<ElementKind, MshError> {
    let number = cursor.integer("an element type")?;
    kind_of(number).map_err(|fault| cursor.error(fault))
}

fn tag_count(cursor: &mut Cursor<'_>) -> Result<usize, MshError> {
    let what = "the number of tags";
    let declared = cursor.natural(what)?;
    cursor.bounded(what, declared, 1)
}

/// Tags and nodes of one element, joined to the last block where they fit.
fn element(
    cursor: &mut Cursor<'_>,
    kind: ElementKind,
    tags: usize,
    blocks: &mut Vec<Block>,
) -> Result<(), MshError> {
    let mut physical = 0;
    for position in 0..tags {
        let tag = cursor.integer("a tag")?;
        if position == 0 {
            physical = tag;
        }
    }
    let owner = Owner::Physical(cursor.group_number(physical)?);
    if blocks
        .last()
        .is_none_or(|last| last.kind != kind || last.owner != owner)
    {
        blocks.push(Block {
            kind,
            owner,
            nodes: Vec::new(),
        });
    }
    let Some(block) = blocks.last_mut() else {
        return Ok(());
    };
    let first = block.nodes.len();
    for _ in 0..kind.nodes {
        block.nodes.push(cursor.natural("a node number")?);
    }
    reorder(kind, block.nodes.get_mut(first..).unwrap_or_default());
    Ok(())
}
