// SPDX-License-Identifier: MIT
// Files that assimp may read: the model's bytes, which are already in memory, and regular files
// that the model may reference (path_rules.h). For a child process: uses no context.
#pragma once

#include <assimp/cfileio.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { STP_ASSIMP_OPENED = 256 };

#define STP_ASSIMP_SECONDS 30 ///< CPU time for any model; larger files get more

/// Additional CPU time for a file of this many bytes. Readers are far faster, except those in an
/// endless loop.
static inline uint64_t stp_assimp_seconds_for(uint64_t bytes)
{
    return bytes / 10000;
}

typedef struct stp_assimp_files {
    struct aiFileIO io; ///< passed to assimp
    const char* path;   ///< path of the model
    const unsigned char* bytes;
    size_t size;
    bool alone; ///< only the model itself may be read
    // the first files that were opened: each adds time only once
    uint64_t opened[STP_ASSIMP_OPENED];
    unsigned opened_count;
    // files that exist but were refused
    unsigned refused;   ///< 0, 1, or 2: several
    char first[300];    ///< the reference
    const char* reason; ///< "it is an absolute path"
} stp_assimp_files;

/// Opening a file for the first time raises the CPU time limit, up to the process' hard limit. The
/// model's path and bytes must outlive this, and `files` must stay at this address until reading
/// ends.
void stp_assimp_files_begin(stp_assimp_files* files, const char* path, const unsigned char* bytes,
                            size_t size, bool alone);
