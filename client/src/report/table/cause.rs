//! Why a step ended early, and what helps, in a mechanic's words.

use signorini_proto::v1::Cause;

/// A sentence for a cause; none when there is nothing to explain.
pub(crate) fn cause(cause: Cause) -> Option<&'static str> {
    let sentence = match cause {
        Cause::Unspecified => return None,
        Cause::Stagnation => {
            "rounding hides the rest of the error: look for moduli or sizes many orders of \
             magnitude apart, or give solver.tolerance a larger value"
        }
        Cause::IterationLimit => {
            "it did not come near enough in the iterations it has: give the step more increments, \
             mend bad cells"
        }
        Cause::ActiveSetCycle => {
            "points went in and out of contact without an end: give the step more increments, or \
             mesh the contact finer"
        }
        Cause::StepTooSmall => {
            "no equilibrium was found even over very small parts of the increment: is the body \
             held, is a corner pressed, is a cell bad there?"
        }
        Cause::LineSearch => {
            "no motion came nearer to an equilibrium: give the step more increments, mend bad cells"
        }
        Cause::NoEquilibrium => {
            "nothing holds the body against these loads, or a pushed obstacle or support against its force: \
             give a [[support]], or an obstacle that they press it onto; push only where contact \
             or friction resists"
        }
        Cause::EnclosedVolume => {
            "a full body that cannot change its volume is pressed: leave it a free surface, or \
             give the material a bulk_modulus"
        }
        Cause::NotFinite => {
            "numbers grew without bound: are moduli and lengths in one set of units, and is the \
             body held?"
        }
        Cause::IndefiniteTangent => {
            "the body has no stiffness left in some motion: is it held, is the material softening?"
        }
        Cause::LimitPoint => {
            "no equilibrium lies beyond this load or travel: the body gives way, or the mesh is \
             too coarse where it is strained most"
        }
        Cause::UnstableEquilibrium => {
            "the body would snap or buckle here: leave solver.on_instability out to let it fall to \
             the next equilibrium, or model half of a symmetric body"
        }
        Cause::NegativeJacobian => {
            "cells would turn inside out: mesh finer, or round the corner that presses"
        }
        Cause::InsideOut => {
            "a cell is inside out between the points where stress is taken: mesh finer there, or \
             round the corner that presses"
        }
        Cause::Leaks => {
            "a fluid reaches what must stay dry: fluids.NAME.blow_off says at which pressure; where \
             that rises ask for `to blow-off`, or squeeze more; where a part moves it has opened \
             the seal"
        }
        Cause::ServerTimeLimit => {
            "the step took as long as any step may on this server (maximum_step_seconds): give it \
             more increments, or ask for a longer time"
        }
    };
    Some(sentence)
}
