// SPDX-License-Identifier: MIT
// A file while it is written, for the files that do it: writer.c (the whole), writer_sections.c (the directory),
// writer_blocks.c (the data).
#pragma once

#include "store/columns.h"
#include "store/page_sums.h"
#include "store/records.h"
#include "store/writer.h"

typedef struct stp_store_writing {
    stp_context* context;
    const stp_store_content* content;
    const char* path;
    stp_file_writer* file;
    stp_store_plan plan;
    uint32_t types[STP_SECTION_END]; ///< of the sections, as they lie in the file
    uint32_t section_count;
    stp_store_section sections[STP_SECTION_END]; ///< by type
    stp_store_text text, object_text;
    stp_store_summary summary;
    uint32_t crc; ///< of the section or block being written
    stp_store_page_sums sums;
} stp_store_writing;

/// Appends bytes of the section or block being written: `crc` and the pages' checksums take them in.
STP_MUST_USE stp_result stp_store_emit(stp_store_writing* w, const void* bytes, size_t size);
/// Zero bytes up to the next multiple; not part of any checksum.
STP_MUST_USE stp_result stp_store_pad(stp_store_writing* w);
/// Codes one element into `bytes`, which has room for a record.
STP_MUST_USE stp_result stp_store_code_element(stp_store_writing* w, uint32_t type, uint32_t index,
                                               stp_store_element* element, unsigned char* bytes);

/// Reserves header and section table, and writes every section.
STP_MUST_USE stp_result stp_store_write_directory(stp_store_writing* w);
/// Writes every block, where the plan has it, and takes down its checksum.
STP_MUST_USE stp_result stp_store_write_blocks(stp_store_writing* w);
/// Writes the block table over that of the directory, now that offsets and checksums are known.
STP_MUST_USE stp_result stp_store_patch_blocks(stp_store_writing* w);
