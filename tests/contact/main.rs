//! Stories of contact: the space of the pressure, the true surface, bodies that obstacles hold, families of scenes.

#[path = "../common/mod.rs"]
mod common;

mod confined_rubber;
mod contact_alone;
mod contact_space;
mod critical_pressure;
mod families;
mod fluid_flow;
mod fluid_meetings;
mod fluids;
mod fluids_by_symmetry;
mod grids;
mod held_by_obstacles;
mod held_rims;
mod hertz;
mod inf_sup;
mod large_surface;
mod passing;
mod pushed;
mod pushed_out;
mod response;
mod rotated_surfaces;
mod tools;
mod true_surface;
mod wavy;
