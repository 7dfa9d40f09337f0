//! Goals of a converged increment: the functionals whose error and derivatives are asked for, by
//! one dual solution each,
//!
//! ```text
//! R(x; t) = 0,   K^T y = dJ/dx,   dJ/dt = d/dt [J(x, t) + y . R(x, t)] at fixed x
//! ```
//!
//! x displacement, pressure and the multipliers of closed contacts, R the residuals (force, volume,
//! gap), K the matrix of the last program made anew at the state, with the curvature of the gaps.
//! Contacts stay closed or open as they are: where one is at its border J has two one-sided
//! derivatives, and the report counts such contacts.
//!
//! | file | part |
//! |---|---|
//! | [`error`] | why a goal has no answer |
//! | [`resolved`], [`own_contact`], [`transposed`] | J and dJ/dx |
//! | [`answer`] | questions and their order |
//! | [`history`], [`border`] | states that depend on their way, derivatives that are one-sided |
//! | [`dual`] | y, by the operators that the solver has |
//! | [`freed`] | a goal whose poses follow from pushes |
//! | [`bound`], [`form`] | the error of J by the mesh, from the errors of x and y |
//! | [`nodes`] | the derivative by the places of all vertices |
//! | [`parameters`], [`change`], [`perturbed`], [`gradient`] | the derivative of J + y . R with the state held fast |
//!
//! Where points slip x has no traction of its own: it follows its pressure, so that K is not
//! symmetric. Nothing of a session is changed by asking. Bodies whose state does not depend
//! on its way; with friction see [`history`].

mod answer;
mod border;
mod bound;
mod change;
mod dual;
mod error;
mod form;
mod freed;
mod gradient;
mod history;
mod nodes;
mod own_contact;
mod parameters;
mod perturbed;
mod resolved;
mod transposed;

pub use error::GoalError;

pub(crate) use answer::{Answers, answer};
