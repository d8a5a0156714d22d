// SPDX-License-Identifier: MIT
// The state of an open file, shared by the files that read and check it.
#pragma once

#include "base/io/file.h"
#include "store/bytes/deflate.h"
#include "store/file/records.h"
#include "store/file/validate.h"

/// The parts of a packed section that have been read.
typedef struct stp_store_packed {
    /// File offsets of its pages, and the end of the last one; NULL: not read yet.
    uint64_t* offsets;
    unsigned char* content; ///< buffer for decoded pages; NULL until the first one
    uint8_t* here;          ///< one bit per page of `content` that is decoded
} stp_store_packed;

struct stp_store {
    stp_context* context;
    char* path;
    stp_mapped_file file;
    bool mapped;         ///< false: the caller owns the bytes
    size_t mapped_bytes; ///< can exceed file.size: desc.partial_bytes
    int descriptor;      ///< file descriptor of the mapped file; -1: none
    stp_store_open_desc desc;

    uint64_t file_bytes;  ///< according to the header
    uint64_t data_offset; ///< end of the directory, start of the blocks
    uint64_t section_end; ///< end of the section table
    uint32_t minor;       ///< minor version
    uint32_t section_count;
    stp_store_section sections[STP_STORE_SECTION_LIMIT];
    stp_store_packed packed[STP_STORE_SECTION_LIMIT]; ///< by section
    stp_store_unpacker* unpacker;                     ///< created on first use
    const stp_store_section* known[STP_SECTION_END];  ///< by type; NULL: not in the file

    void* tables[STP_SECTION_END]; ///< decoded records, by section type
    uint32_t counts[STP_SECTION_END];
    stp_store_directory directory;
    stp_store_summary summary; ///< its parts belong to the table
    stp_store_method* methods; ///< methods of the directory
    uint32_t* method_sets;     ///< for all methods but the first: by method, then by node
    /// For each octave, then each point set: the record of its attribute block, or STP_STORE_NONE.
    /// NULL if the file has no such blocks.
    uint32_t* attribute_blocks;
    uint32_t* level_starts; ///< of the directory; NULL: no levels
    stp_store_coloring coloring;
    bool objects_ready;
    bool only_summary; ///< opened for its summary: the graph and everything below it was not read
    uint8_t* pages_checked; ///< one bit per page of unpacked sections, then one per section
    bool page_table_checked;
    uint64_t bytes_checked;           ///< bytes of the directory verified so far
    struct stp_store_key_table* keys; ///< created on first use
    struct stp_store_large** large;   ///< lists of large triangles by mesh; created on first use
    uint64_t arrivals;                ///< counts loads of bulk data by all residencies
    struct stp_residency* residency;  ///< loads bulk data; NULL: data is used as mapped
};

static inline stp_store_validator stp_store_own_validator(const stp_store* store)
{
    return (stp_store_validator){
        .context = store->context, .path = store->path, .failure = STP_ERROR_FORMAT};
}
