// SPDX-License-Identifier: MIT
// The internals of a store, shared by the files that make, read and check it.
#pragma once

#include "base/io/file.h"
#include "store/bytes/chunks.h"
#include "store/bytes/columns.h"
#include "store/bytes/packed.h"
#include "store/bytes/values.h"
#include "store/file/records.h"
#include "store/file/validate.h"
#include "store/sets/coloring.h"

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

/// CRC-32 as zlib computes it. To chain calls, pass the previous value; start with 0.
uint32_t stp_store_crc(uint32_t crc, const void* bytes, size_t size);

/// Reads the header and the section table. Fills file_bytes, data_offset, sections and known.
STP_MUST_USE stp_result stp_store_read_header(stp_store* store);

/// Verifies the checksum of a section.
STP_MUST_USE stp_result stp_store_verify_section(stp_store* store,
                                                 const stp_store_section* section);
/// The verified texts of a section; empty if the file has none.
STP_MUST_USE stp_result stp_store_read_text(stp_store* store, uint32_t type, stp_store_text* text);
/// Verifies the pages that hold a text, and counts its use (stp_store_use_text). NULL is valid.
/// @return STP_OK, FORMAT, OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_store_verify_text(stp_store* store, uint32_t type, stp_store_text* uses,
                                              const char* text);
/// Decodes the records of a section into `tables` and `counts`.
STP_MUST_USE stp_result stp_store_read_table(stp_store* store, uint32_t type, stp_store_text* text);
/// Validates the decoded summary and scene parts.
STP_MUST_USE stp_result stp_store_validate_summary(stp_store* store);
/// Reads only what a summary needs, not the whole directory.
STP_MUST_USE stp_result stp_store_read_head(stp_store* store);
/// Checks the page checksums themselves and the first page of every section.
STP_MUST_USE stp_result stp_store_check_head(stp_store* store);

/// Verifies the pages that hold a byte range of a section, once each; without page checksums, the
/// whole section.
STP_MUST_USE stp_result stp_store_verify_range(stp_store* store, const stp_store_section* section,
                                               uint64_t offset, uint64_t size);
/// Start of a section's records. In a packed section, stp_store_verify_range must decode pages
/// first.
STP_MUST_USE stp_result stp_store_find_content(stp_store* store, const stp_store_section* section,
                                               const unsigned char** content);

// Packed sections.
/// Verifies the table of pages, once. Required before reading pages.
STP_MUST_USE stp_result stp_store_open_packed(stp_store* store, const stp_store_section* section);
/// Decoded size of a page.
size_t stp_store_page_size(const stp_store_section* section, uint64_t page);
/// Verifies a page and decodes it into `out`.
STP_MUST_USE stp_result stp_store_read_page(stp_store* store, const stp_store_section* section,
                                            uint64_t page, void* out);
/// Verifies the table and at most `pages` pages, without keeping them.
STP_MUST_USE stp_result stp_store_check_packed(stp_store* store, const stp_store_section* section,
                                               uint64_t pages);
/// Decodes the pages that hold a byte range of the content, once each.
STP_MUST_USE stp_result stp_store_unpack_range(stp_store* store, const stp_store_section* section,
                                               uint64_t offset, uint64_t size);
void stp_store_free_packed(stp_store* store);

/// Verifies the table of page checksums itself, once.
STP_MUST_USE stp_result stp_store_verify_page_table(stp_store* store);

/// Compares the summary with the file's content.
STP_MUST_USE stp_result stp_store_check_summary(stp_store* store);

/// Frees the table of keys.
void stp_store_free_keys(stp_store* store);

/// Links octaves, breakpoints and blocks to their sets, meshes, point sets and textures.
STP_MUST_USE stp_result stp_store_link_blocks(stp_store* store);

/// Cuts a set to its first `octave_count` octaves, and its tables accordingly.
void stp_store_truncate_splat_set(stp_splats* splats, uint32_t octave_count);

/// Size of the joined columns of this many octaves.
uint64_t stp_store_columns_bytes(const stp_splats* splats, uint32_t octave_count);
/// Allocates the columns for all octaves of a (cut) set. NULL if memory runs out, not logged.
stp_store_joined* stp_store_reserve_columns(stp_context* context, stp_splats* splats);
/// Copies octaves from another copy of the set's columns.
void stp_store_copy_columns(const stp_splats* splats, const stp_splats* before,
                            uint32_t octave_count);
/// Number of groups of this many splats.
static inline uint64_t stp_store_group_count(uint64_t splats)
{
    return (splats + STP_GROUP_SPLATS - 1) / STP_GROUP_SPLATS;
}

/// Makes the groups that contain splats [first, end) of a set with ranges. Splats before `end` must
/// be there.
void stp_store_make_groups(const stp_splats* splats, uint32_t first, uint32_t end);

/// Verifies an octave's block and copies its columns. Earlier octaves must be there.
STP_MUST_USE stp_result stp_store_add_octave(stp_store* store, uint32_t index, uint32_t octave,
                                             const stp_splats* splats);
/// Whether any of the first octaves of a set is coded as operators.
bool stp_store_has_operators(const stp_store* store, uint32_t index, uint32_t octave_count);

/// Destinations of an octave's columns within a set's columns.
void stp_store_octave_targets(const stp_splats* splats, uint32_t octave,
                              void* targets[STP_OCTAVE_COLUMNS]);
/// Hands columns to a set. The caller takes over the old ones.
void stp_store_set_columns(stp_store_set_record* record, stp_store_joined* joined,
                           const stp_splats* columns, uint32_t octave_count);

// Pointers into a block's bytes. Only clusters are checked: @return what is wrong, or NULL.
void stp_store_find_mesh_columns(uint32_t present, const unsigned char* bytes,
                                 stp_store_mesh* mesh);
void stp_store_find_point_columns(uint32_t present, const unsigned char* bytes,
                                  stp_store_point_set* points);
const char* stp_store_find_clusters(const stp_store* store, uint32_t index,
                                    const unsigned char* bytes, stp_clusters* clusters);

/// Checks the decoded certainty records.
STP_MUST_USE stp_result stp_store_validate_certainty(const stp_store* store);
/// Checks them and assigns them to the sets, which must be read.
STP_MUST_USE stp_result stp_store_link_certainty(stp_store* store);

/// Reads the methods, before blocks are linked. A file without the section has sets of `blue`
/// alone.
STP_MUST_USE stp_result stp_store_read_methods(stp_store* store, stp_store_text* text);
/// Reads only the methods, for a store opened for its summary.
STP_MUST_USE stp_result stp_store_read_method_names(stp_store* store, stp_store_text* text);

/// Reads attribute statistics and coordinate systems. Sources must be there.
STP_MUST_USE stp_result stp_store_read_figures(stp_store* store, stp_store_text* text);
/// Links attribute blocks to their owners, which must be linked.
STP_MUST_USE stp_result stp_store_link_attributes(stp_store* store);
/// The attribute block of an octave or point set, read from the mapped file. `block` is NULL if
/// there is none.
stp_store_values stp_store_values_of(const stp_store* store, uint32_t kind, uint32_t owner,
                                     uint32_t octave);
/// Whether colours or coverages replace the file's own.
bool stp_store_is_colored(const stp_store* store);
/// Frees the memory made for points; the next use reads them again.
void stp_store_release_points(stp_store* store);
/// Gives a point record the columns of the set that holds its points. The record owns the memory.
/// @return STP_OK, STP_ERROR_TRUNCATED, or as stp_store_get_splat_set
STP_MUST_USE stp_result stp_store_make_held_points(stp_store* store, uint32_t index,
                                                   stp_store_point_record* record);

/// Replaces colours and coverages of an octave that was just read by the store's colouring. Earlier
/// octaves must be there. `source` reads the file. Does nothing if points are not coloured. @return
/// as stp_store_read_chunks
const char* stp_store_color_octave(const stp_store* store, uint32_t index, uint32_t octave,
                                   const stp_splats* splats, const stp_store_block_source* source,
                                   uint64_t* read_bytes);
/// Makes the colours of a point set, 4 bytes each. `colors`: its own, NULL for white.
const char* stp_store_color_points(const stp_store* store, uint32_t index, const uint8_t* colors,
                                   const stp_store_block_source* source, uint8_t* colored,
                                   uint64_t* read_bytes);
/// Checks the whole content of an attribute block.
STP_MUST_USE stp_result stp_store_check_values(stp_store* store, const stp_store_block* block);

typedef struct stp_store_large stp_store_large;
/// Frees the lists of large triangles.
void stp_store_free_large(stp_store* store);

/// Frees the columns of a set.
void stp_store_free_columns(stp_context* context, stp_store_set_record* record);

/// Whether the file holds a whole block; false only for partial files.
bool stp_store_is_block_here(const stp_store* store, const stp_store_block* block);
/// Entry of the block table.
const stp_store_block* stp_store_block_at(const stp_store* store, uint32_t index);
/// Reports an index out of range: STP_ERROR_ARGUMENT.
stp_result stp_store_fail_index(const stp_store* store, const char* what, uint32_t index);
/// The block of a set's octave.
const stp_store_block* stp_store_octave_block(const stp_store* store, uint32_t index,
                                              uint32_t octave);
/// Reads a part of the mapped file (stp_store_block_source); `user` is the store.
bool stp_store_read_mapped(void* user, uint64_t offset, void* bytes, size_t size);
/// Reports a damaged or missing block: STP_ERROR_FORMAT, STP_ERROR_TRUNCATED.
stp_result stp_store_fail_block(const stp_store* store, const stp_store_block* block,
                                const char* what);
/// Verifies that a block is complete and undamaged. Returns its first byte in `bytes`.
STP_MUST_USE stp_result stp_store_verify_block(const stp_store* store, const stp_store_block* block,
                                               const unsigned char** bytes);
