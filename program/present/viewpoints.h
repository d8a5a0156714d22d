// SPDX-License-Identifier: MIT
//
// Named cameras with notes, visibility states, sections and annotations, stored beside a model in
// NAME.views.json next to NAME.stip (or NAME.glb, ...), docs/viewpoints.md. The model itself is
// never changed.
#pragma once

#include "base/core/context.h"

#include <stipple/view.h>

/// A note at a point.
typedef struct stp_annotation {
    char* text;
    stp_vec3d point; ///< scene space
    char* object;    ///< path of the annotated object; NULL: none
} stp_annotation;

typedef enum stp_shown_as {
    STP_SHOWN_HIDDEN,
    STP_SHOWN_ISOLATED,
    STP_SHOWN_GHOST,
    STP_SHOWN_FOCUSED, ///< all others are ghosts
    STP_SHOWN_KINDS,
} stp_shown_as;

/// An object that is not shown as usual, identified by its path and position.
typedef struct stp_shown_object {
    stp_shown_as as;
    char* path; ///< as stp_outline_path gives it
    bool has_position;
    stp_vec3d position; ///< centre of its box: distinguishes objects with the same path
} stp_shown_object;

typedef struct stp_viewpoint {
    char* name;
    char* note; ///< NULL: none
    stp_vec3d eye, target, up;
    double fov_degrees;  ///< 0: unspecified
    double ortho_height; ///< 0: perspective
    stp_sections sections;
    stp_shown_object* objects;
    size_t object_count;
    stp_annotation* annotations;
    size_t annotation_count;
} stp_viewpoint;

/// Initialise to zero: none. Texts and arrays come from stp_alloc of the context.
typedef struct stp_viewpoints {
    stp_viewpoint* views;
    size_t count, capacity;
} stp_viewpoints;

#define STP_VIEWPOINTS_BYTES_MAX ((size_t)1 << 24) ///< size limit of a file
enum {
    STP_VIEWPOINTS_MAX = 4096,
    STP_VIEWPOINT_TEXT_MAX = 65536, ///< size limit of a text
};

/// Path of a model's sidecar file: its last extension becomes ".views.json". From stp_alloc; NULL:
/// out of memory.
char* stp_viewpoints_path(stp_context* context, const char* model_path);

/// Reads a file. A missing file has no viewpoints.
/// @return STP_OK, STP_ERROR_IO, STP_ERROR_FORMAT, STP_ERROR_VERSION, STP_ERROR_LIMIT,
/// STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_viewpoints_read(stp_context* context, const char* path,
                                            stp_viewpoints* viewpoints);
/// Parses viewpoints from memory; `name` begins the error message.
STP_MUST_USE stp_result stp_viewpoints_parse(stp_context* context, const char* name,
                                             const unsigned char* bytes, size_t size,
                                             stp_viewpoints* viewpoints);
/// Writes to a temporary file and renames it: a reader sees the old file or the new one. @return
/// STP_OK, IO, LIMIT, ARGUMENT (a text is not UTF-8, or memory ran out); logged
STP_MUST_USE stp_result stp_viewpoints_write(stp_context* context, const char* path,
                                             const stp_viewpoints* viewpoints);
void stp_viewpoints_destroy(stp_context* context, stp_viewpoints* viewpoints);

/// Adds a copy; replaces one of the same name. @return STP_OK, LIMIT, OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_viewpoints_put(stp_context* context, stp_viewpoints* viewpoints,
                                           const stp_viewpoint* viewpoint);
/// @return whether it existed
bool stp_viewpoints_remove(stp_context* context, stp_viewpoints* viewpoints, const char* name);
/// NULL if there is none of that name.
const stp_viewpoint* stp_viewpoints_find(const stp_viewpoints* viewpoints, const char* name);
/// Sets eye, target, up, angle (if the viewpoint has one), projection and sections of `view`.
void stp_viewpoint_get_view(const stp_viewpoint* viewpoint, stp_view* view);
