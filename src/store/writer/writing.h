// SPDX-License-Identifier: MIT
// A file being written, shared by writer.c (the whole), writer_sections.c and writer_packed.c (the
// directory), and writer_blocks.c, writer_chunks.c and writer_attributes.c (the data).
#pragma once

#include "base/io/file.h"
#include "store/bytes/page_sums.h"
#include "store/file/block_order.h"
#include "store/file/records.h"

/// A packed section being written.
typedef struct stp_store_packing stp_store_packing;

typedef struct stp_store_writing {
    stp_context* context;
    const stp_store_content* content;
    const char* path;
    stp_file_writer* file;
    stp_store_plan plan;
    uint32_t types[STP_SECTION_END]; ///< types of the sections, in file order
    uint32_t section_count;
    stp_store_section sections[STP_SECTION_END]; ///< by type
    stp_store_text text, object_text;
    stp_store_summary summary;
    stp_store_attribute attributes[STP_ATTRIBUTES]; ///< those that point sets have
    stp_store_attribute_value* attribute_values;    ///< owned
    uint32_t attribute_count, attribute_value_count;
    uint32_t crc; ///< checksum of the section or block being written, so far
    stp_store_page_sums sums;
    uint64_t unreleased_bytes;  ///< read from the content since its pages were last released
    stp_store_packing* packing; ///< state of the section being written; NULL: not packed
} stp_store_writing;

/// Octave chunks waiting to be compressed together.
typedef struct stp_store_batch stp_store_batch;
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). Destroy `*batch` in either case
STP_MUST_USE stp_result stp_store_batch_create(stp_store_writing* w, stp_store_batch** batch);
void stp_store_batch_destroy(stp_store_batch* batch);
/// Adds an octave by its block index. Once enough chunks wait, compresses and writes them. Sets
/// offset, size, checksum and encoding of the block in the plan.
STP_MUST_USE stp_result stp_store_batch_add(stp_store_batch* batch, uint32_t block);
/// Writes the remaining chunks.
STP_MUST_USE stp_result stp_store_batch_flush(stp_store_batch* batch);

/// Counts bytes that were read from the content, or written instead; releases its pages when there
/// are many.
void stp_store_count_read(stp_store_writing* w, uint64_t bytes);

/// Computes the attribute statistics.
STP_MUST_USE stp_result stp_store_measure_attributes(stp_store_writing* w);
/// Writes an attribute block and sets its offset, size and checksum.
STP_MUST_USE stp_result stp_store_write_values(stp_store_writing* w, stp_store_block* block);

/// Begins a packed section of known type and record count at the end of the file: `w->packing`.
STP_MUST_USE stp_result stp_store_packing_begin(stp_store_writing* w, stp_store_section* section);
STP_MUST_USE stp_result stp_store_packing_add(stp_store_packing* packing, const void* bytes,
                                              size_t size);
/// Writes the remaining pages and their table; sets size and checksum of the section.
STP_MUST_USE stp_result stp_store_packing_end(stp_store_packing* packing);
void stp_store_packing_destroy(stp_store_writing* w);

/// Appends bytes to the section or block being written; updates `crc` and the page checksums.
STP_MUST_USE stp_result stp_store_emit(stp_store_writing* w, const void* bytes, size_t size);
/// Zero padding up to the next multiple; not part of any checksum.
STP_MUST_USE stp_result stp_store_pad(stp_store_writing* w);
/// Codes one element into `bytes`, which has room for a record.
STP_MUST_USE stp_result stp_store_code_element(stp_store_writing* w, uint32_t type, uint32_t index,
                                               stp_store_element* element, unsigned char* bytes);

/// Reserves header and section table, and writes every section.
STP_MUST_USE stp_result stp_store_write_directory(stp_store_writing* w);
/// Writes every block and sets its offset, size and checksum in the plan.
STP_MUST_USE stp_result stp_store_write_blocks(stp_store_writing* w);
/// Rewrites a section's records: blocks, summary and scene parts are known once all data is
/// written.
STP_MUST_USE stp_result stp_store_patch_section(stp_store_writing* w, uint32_t type,
                                                const void* elements, uint32_t count);
