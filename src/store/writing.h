// SPDX-License-Identifier: MIT
// A file while it is written, for the files that do it: writer.c (the whole), writer_sections.c (the directory),
// writer_blocks.c (the data).
#pragma once

#include "store/columns.h"
#include "store/page_sums.h"
#include "store/plan.h"
#include "store/records.h"
#include "store/writer.h"

/// A packed section while it is written.
typedef struct stp_store_packing stp_store_packing;

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
    stp_store_attribute attributes[STP_ATTRIBUTES]; ///< those that point sets have
    stp_store_attribute_value* attribute_values;    ///< owned
    uint32_t attribute_count, attribute_value_count;
    uint32_t crc; ///< of the section or block being written
    stp_store_page_sums sums;
    stp_store_packing* packing; ///< of the section being written; NULL: it is not packed
} stp_store_writing;

/// The methods of content, and the columns of their sets.
STP_MUST_USE stp_result stp_store_judge_methods(const stp_store_judge* judge,
                                                const stp_store_content* content);

/// Chunks of octaves that wait to be compressed together.
typedef struct stp_store_batch stp_store_batch;
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). In any case `*batch` is to be destroyed
STP_MUST_USE stp_result stp_store_batch_create(stp_store_writing* w, stp_store_batch** batch);
void stp_store_batch_destroy(stp_store_batch* batch);
/// Adds an octave, by the index of its block; when enough wait, they are compressed and written. Offset, size, checksum
/// and encoding of its block are noted in the plan.
STP_MUST_USE stp_result stp_store_batch_add(stp_store_batch* batch, uint32_t block);
/// Writes what waits.
STP_MUST_USE stp_result stp_store_batch_flush(stp_store_batch* batch);

/// Fills the figures of attributes.
STP_MUST_USE stp_result stp_store_measure_attributes(stp_store_writing* w);
/// Writes a block of attributes; its offset, size and checksum are noted in it.
STP_MUST_USE stp_result stp_store_write_values(stp_store_writing* w, stp_store_block* block);

/// Begins a packed section at the end of the file, whose type and records are known: `w->packing`.
STP_MUST_USE stp_result stp_store_packing_begin(stp_store_writing* w, stp_store_section* section);
STP_MUST_USE stp_result stp_store_packing_add(stp_store_packing* packing, const void* bytes,
                                              size_t size);
/// Writes what is left, and the table of pages; size and checksum of the section are set.
STP_MUST_USE stp_result stp_store_packing_end(stp_store_packing* packing);
void stp_store_packing_destroy(stp_store_writing* w);

/// Appends bytes of the section or block being written: `crc` and the pages' checksums take them in.
STP_MUST_USE stp_result stp_store_emit(stp_store_writing* w, const void* bytes, size_t size);
/// Zero bytes up to the next multiple; not part of any checksum.
STP_MUST_USE stp_result stp_store_pad(stp_store_writing* w);
/// Codes one element into `bytes`, which has room for a record.
STP_MUST_USE stp_result stp_store_code_element(stp_store_writing* w, uint32_t type, uint32_t index,
                                               stp_store_element* element, unsigned char* bytes);

/// Reserves header and section table, and writes every section.
STP_MUST_USE stp_result stp_store_write_directory(stp_store_writing* w);
/// Writes every block, and notes in the plan where it is, its size and checksum.
STP_MUST_USE stp_result stp_store_write_blocks(stp_store_writing* w);
/// Writes a section's records over those that the directory has: blocks, summary and scene parts are known when all
/// data is written.
STP_MUST_USE stp_result stp_store_patch_section(stp_store_writing* w, uint32_t type,
                                                const void* elements, uint32_t count);
