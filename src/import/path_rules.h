// SPDX-License-Identifier: MIT Which files a model may name: those in its own folder and below.
// Uses no context, so that a forked child may ask.
#pragma once

/// Where a reference leads: the model's folder and the reference, without "." and "..". Absolute
/// paths, drive letters, URLs, control characters, ".." that leave the folder and links that do are
/// refused. Backslashes separate like slashes. What does not exist is not refused.
/// @param out room for strlen(model) + strlen(reference) + 2 bytes
/// @return NULL, or the reason for a refusal: "it is an absolute path"
const char* stp_path_resolve(const char* model, const char* reference, char* out);
