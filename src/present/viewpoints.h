// SPDX-License-Identifier: MIT
//
// What people keep of a model beside it: cameras with names and notes, what was hidden and cut away there, and remarks at
// points. In a file NAME.views.json next to NAME.stip (or NAME.glb, ...), docs/viewpoints.md; the model is never touched.
#pragma once

#include "base/context.h"

#include <stipple/view.h>

/// A remark at a point.
typedef struct stp_annotation {
    char* text;
    stp_vec3d point; ///< scene space
    char* object;    ///< path of the object it is about; NULL: none
} stp_annotation;

typedef enum stp_shown_as { STP_SHOWN_HIDDEN, STP_SHOWN_ISOLATED, STP_SHOWN_GHOST } stp_shown_as;

/// Something that is not shown as usual: an object by its path, at its place.
typedef struct stp_shown_thing {
    stp_shown_as as;
    char* path; ///< as stp_outline_path gives it
    bool has_position;
    stp_vec3d position; ///< middle of its box: which one, of several of that path
} stp_shown_thing;

typedef struct stp_viewpoint {
    char* name;
    char* note; ///< NULL: none
    stp_vec3d eye, target, up;
    double fov_degrees;  ///< 0: not said
    double ortho_height; ///< 0: perspective
    stp_sections sections;
    stp_shown_thing* things;
    size_t thing_count;
    stp_annotation* annotations;
    size_t annotation_count;
} stp_viewpoint;

/// All zero: none. Texts and arrays are from stp_alloc of the context.
typedef struct stp_viewpoints {
    stp_viewpoint* views;
    size_t count, capacity;
} stp_viewpoints;

#define STP_VIEWPOINTS_BYTES_MOST ((size_t)1 << 24) ///< of a file
enum {
    STP_VIEWPOINTS_MOST = 4096,
    STP_VIEWPOINT_TEXT_MOST = 65536, ///< bytes of a text
};

/// The path of the sidecar of a model: its last extension becomes ".views.json". From stp_alloc; NULL: no memory.
char* stp_viewpoints_path(stp_context* context, const char* model_path);

/// Reads a file; one that is not there has no viewpoints.
/// @return STP_OK, STP_ERROR_IO, STP_ERROR_FORMAT, STP_ERROR_LIMIT, STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_viewpoints_read(stp_context* context, const char* path,
                                            stp_viewpoints* viewpoints);
/// The same from memory; `name` begins the message of a failure.
STP_MUST_USE stp_result stp_viewpoints_parse(stp_context* context, const char* name,
                                             const unsigned char* bytes, size_t size,
                                             stp_viewpoints* viewpoints);
/// Writes aside and renames: a reader sees the old file or the new one. @return STP_OK, IO, LIMIT, OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_viewpoints_write(stp_context* context, const char* path,
                                             const stp_viewpoints* viewpoints);
void stp_viewpoints_destroy(stp_context* context, stp_viewpoints* viewpoints);

/// Adds a copy, in place of one of the same name. @return STP_OK, LIMIT, OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_viewpoints_put(stp_context* context, stp_viewpoints* viewpoints,
                                           const stp_viewpoint* viewpoint);
/// @return whether there was one
bool stp_viewpoints_remove(stp_context* context, stp_viewpoints* viewpoints, const char* name);
/// NULL: there is none of that name.
const stp_viewpoint* stp_viewpoints_find(const stp_viewpoints* viewpoints, const char* name);
/// Sets eye, target, up, angle (where the view point says one), projection and sections of `view`.
void stp_viewpoint_look(const stp_viewpoint* viewpoint, stp_view* view);
