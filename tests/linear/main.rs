//! Stories of linear bodies and of everything that all bodies share: scenes, steps, results, estimates.

#[path = "../common/mod.rs"]
mod common;

mod about_axis;
mod bad_methods;
mod bad_scenes;
mod bad_steps;
mod balance;
mod cook_membrane;
mod counts;
mod determinism;
mod doubts;
mod estimate;
mod extremes;
mod given_values;
mod lifted;
mod method_names;
mod nodal_force;
mod normal_supports;
mod patch;
mod plan_doubts;
mod plane_stress;
mod references;
mod soft_volumes;
mod steps;
mod stokes;
mod taylor_hood_orders;
mod units;
