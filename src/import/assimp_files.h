// SPDX-License-Identifier: MIT
// The files that assimp may read: the model's bytes, which are here already, and regular files that the model may name
// (path_rules.h). For a child process: uses no context.
#pragma once

#include <assimp/cfileio.h>
#include <stdbool.h>
#include <stddef.h>

typedef struct stp_assimp_files {
    struct aiFileIO io; ///< what assimp is given
    const char* path;   ///< of the model
    const unsigned char* bytes;
    size_t size;
    bool alone; ///< only the model may be read
    // what was refused though it exists
    unsigned refused;   ///< 0, 1, or 2: several
    char first[300];    ///< the reference
    const char* reason; ///< "it is an absolute path"
} stp_assimp_files;

/// The model's path and bytes must outlive it; so must `files` all reading, at this address.
void stp_assimp_files_begin(stp_assimp_files* files, const char* path, const unsigned char* bytes,
                            size_t size, bool alone);
