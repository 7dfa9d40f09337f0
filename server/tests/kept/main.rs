//! What a server keeps: results, states, meshes and tools over kills, releases and damage.

#[path = "../common/mod.rs"]
mod common;

mod damage;
mod final_results;
mod first_release;
mod same_bits;
mod saves;
mod tools;
