// SPDX-License-Identifier: MIT
//
// Everything a program needs to embed Stipple; docs/embedding.md is the guide.
//
//   stp_context   memory, log, progress, threads         base.h
//   stp_model     an opened `.stip` file                 model.h, pick.h
//   stp_painter   draws a model: pixels or OpenGL        paint.h
//   stp_builder   triangles and points to a `.stip`      build.h
//   points in an order of which every prefix covers all  order.h
//
// Rules that hold everywhere:
//
// *Errors.* A function that can fail returns stp_result; its text is stp_result_string. The context's log gets
// one sentence that says which file and what was wrong. Out-parameters are set on STP_OK only; those that give an
// object are NULL after a failure.
//
// *Descriptors* (structs named ..._desc) may be zero: a field left zero means its default. They grow at their end.
// `struct_size` says how much of one the caller knows: sizeof, or 0 for its first version. A library that is older
// than the headers refuses fields that it does not know (STP_ERROR_UNSUPPORTED) unless they are zero. Structs that
// are filled by the library (..._info, ..._report, stp_hit) grow the same way: set struct_size before the call.
//
// *Threads.* A context and all objects made with it belong to one thread at a time. Threads that work at the same
// time have a context each, and open files for themselves. Exceptions say so: stp_painter_set_stopped.
//
// *Ownership.* Who creates an object destroys it, before what it was made from: painter, model, builder, context.
// Texts and arrays that a function gives belong to the object it was asked of, and live as long.
//
// *Space.* Scene space is right-handed, y is up, lengths are in the file's unit (stp_model_info.unit_metres).
#pragma once

#include <stipple/attributes.h>
#include <stipple/base.h>
#include <stipple/build.h>
#include <stipple/image.h>
#include <stipple/measure.h>
#include <stipple/model.h>
#include <stipple/order.h>
#include <stipple/paint.h>
#include <stipple/pick.h>
#include <stipple/types.h>
#include <stipple/version.h>
#include <stipple/view.h>
