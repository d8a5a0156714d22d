// SPDX-License-Identifier: MIT
// Reports of commands: objects found, things picked, point files, and sizes of a build.
#pragma once

#include "builder/build_scene.h"
#include "import/reading/scan_info.h"
#include "program/drawing/show_options.h"
#include "program/options/command.h"
#include "program/reports/describe.h"
#include "scene/scene.h"
#include "store/file/store.h"

#include <stipple/view.h>

#include <jansson.h>

// Lists the objects of a scene that match a text, one per line or as JSON.

enum { FIND_MAX = 1000 }; ///< maximum number of reported objects

/// Prints objects whose name or id contains the text. @return the exit code, with the message
/// printed
int find_print(stp_context* context, stp_store* store, const char* text, bool as_json);

// Reports what is visible at a position of the picture, as JSON.

/// Reads two numbers separated by a comma. @return false on a syntax error
bool pick_read_place(const char* text, double place[2]);

/// Reports the original triangles or points at a pixel; `back_faces` as in stp_pick_desc. NULL on
/// failure: logged or printed.
json_t* pick_describe(scene_show* show, const stp_view* view, bool back_faces,
                      const double place[2]);

// The output of `stipple info` for a point file.

/// Prints a header that was read without its points, as text or as one JSON object, on stdout.
/// `scene` holds the source. @return exit code
int scan_report_print(const char* path, const stp_scene* scene, const stp_scan_info* info,
                      bool json);

/// The value of "scan" in the JSON object.
json_t* scan_report_json(const stp_scene* scene, const stp_scan_info* info);
/// Prints lines that list the values of the points, on stdout.
void scan_report_print_fields(const stp_scan_info* info);

// The output of `stipple build`: figures of the file, times of the build, and sizes.

/// Prints a summary of the written file, read back from the file itself, as text or as one JSON
/// object, on stdout. @return the exit code, with the message printed
int build_report_print(stp_context* context, const char* path, const stp_build_report* report,
                       uint64_t input_bytes, bool as_json);

/// Size of the inputs in bytes: each file, and the buffers and pictures that a .gltf names. Named
/// scenes and unreadable files count as 0.
uint64_t build_sizes_input(const char* const* inputs, size_t count);

/// Whether the file has splats although the scene has no points and so few triangles (counting all
/// uses) that drawing all of them is quick.
bool build_sizes_needs_no_splats(const scene_figures* figures);

/// Prints on stdout: a notice if splats are not needed, the reason if the output is more than three
/// times as large as the input, and the sizes of both.
void build_sizes_print(uint64_t input_bytes, const scene_figures* figures);
