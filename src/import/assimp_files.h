// SPDX-License-Identifier: MIT The files that assimp may read: the model's bytes, which are here
// already, and regular files that the model may name (path_rules.h). For a child process: uses no
// context.
#pragma once

#include <assimp/cfileio.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { STP_ASSIMP_OPENED = 256 };

#define STP_ASSIMP_SECONDS 30 ///< of processor time for any model, and more for its bytes

/// How much longer it may take to read so many bytes. Readers are far faster, but for what takes no
/// end.
static inline uint64_t stp_assimp_seconds_for(uint64_t bytes)
{
    return bytes / 10000;
}

typedef struct stp_assimp_files {
    struct aiFileIO io; ///< what assimp is given
    const char* path;   ///< of the model
    const unsigned char* bytes;
    size_t size;
    bool alone; ///< only the model may be read
    // what was opened lately: time is allowed for each file once
    uint64_t opened[STP_ASSIMP_OPENED];
    unsigned opened_count;
    // what was refused though it exists
    unsigned refused;   ///< 0, 1, or 2: several
    char first[300];    ///< the reference
    const char* reason; ///< "it is an absolute path"
} stp_assimp_files;

/// The limit of processor time grows with the first files that are opened, up to the process' hard
/// limit. The model's path and bytes must outlive it; so must `files` all reading, at this address.
void stp_assimp_files_begin(stp_assimp_files* files, const char* path, const unsigned char* bytes,
                            size_t size, bool alone);
