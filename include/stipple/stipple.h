// SPDX-License-Identifier: MIT
//
// Everything a program needs to embed Stipple; docs/embedding.md is the guide.
//
//   stp_context   memory, log, progress, threads         base.h
//   stp_model     an opened `.stip` file                 model.h, pick.h
//   stp_painter   draws a model: pixels or OpenGL        paint.h
//   stp_builder   triangles and points to a `.stip`      build.h
//   progressive point orders                            order.h
//
// General rules:
//
// *Errors.* A function that can fail returns stp_result; stp_result_string gives its text. The
// context's log receives one sentence that names the file and the problem. Out-parameters are set
// on STP_OK only; those that return an object are NULL after a failure.
//
// *Descriptors* (structs named ..._desc) may be zero: zero selects the default of each field. New
// versions append fields. `struct_size` says which fields the caller knows: sizeof, or 0 for the
// first version. A library older than the headers rejects unknown fields (STP_ERROR_UNSUPPORTED)
// unless they are zero. Structs filled by the library (..._info, ..._report, stp_hit) grow the same
// way: set struct_size before the call.
//
// *Threads.* A context and its objects may be used by one thread at a time. To work in parallel,
// give each thread its own context and let it open its own files. Exceptions are documented:
// stp_painter_set_stopped.
//
// *Ownership.* The creator of an object destroys it, before the object it was made from: painter,
// model, builder, context. Returned texts and arrays belong to the object that returned them, and
// live as long.
//
// *Space.* Scene space is right-handed, y is up, lengths are in the file's unit
// (stp_model_info.unit_metres).
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
