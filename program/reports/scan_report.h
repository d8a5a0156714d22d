// SPDX-License-Identifier: MIT
//
// The output of `stipple info` for a point file.
#pragma once

#include "import/reading/scan_info.h"
#include "scene/scene.h"

#include <jansson.h>

/// Prints a header that was read without its points, as text or as one JSON object, on stdout.
/// `scene` holds the source. @return exit code
int scan_report_print(const char* path, const stp_scene* scene, const stp_scan_info* info,
                      bool json);

/// The value of "scan" in the JSON object.
json_t* scan_report_json(const stp_scene* scene, const stp_scan_info* info);
/// Prints lines that list the values of the points, on stdout.
void scan_report_print_fields(const stp_scan_info* info);
