// SPDX-License-Identifier: MIT
// What a store is inside, for the files that make, read and check it.
#pragma once

#include "base/file.h"
#include "store/chunks.h"
#include "store/coloring.h"
#include "store/columns.h"
#include "store/packed.h"
#include "store/records.h"
#include "store/validate.h"
#include "store/values.h"

/// What was read of a packed section.
typedef struct stp_store_packed {
    uint64_t* offsets; ///< of its pages in the file, and the end of the last; NULL: not read yet
    unsigned char*
        content;   ///< where pages are decoded to as they are asked for; NULL: none was yet
    uint8_t* here; ///< a bit for each page of `content`
} stp_store_packed;

struct stp_store {
    stp_context* context;
    char* path;
    stp_mapped_file file;
    bool mapped;         ///< else the bytes are the caller's
    size_t mapped_bytes; ///< file.size may be less: desc.prefix_bytes
    int descriptor;      ///< the mapped file, open for reading; -1: none
    stp_store_open_desc desc;

    uint64_t file_bytes;  ///< as the header says
    uint64_t data_offset; ///< where the directory ends and blocks begin
    uint64_t section_end; ///< where the section table ends
    uint32_t minor;       ///< version
    uint32_t section_count;
    stp_store_section sections[STP_STORE_SECTION_LIMIT];
    stp_store_packed packed[STP_STORE_SECTION_LIMIT]; ///< by section
    stp_store_unpacker* unpacker;                     ///< made when first needed
    const stp_store_section* known[STP_SECTION_END];  ///< by type; NULL: the file has none

    void* tables[STP_SECTION_END]; ///< decoded records, by section type
    uint32_t counts[STP_SECTION_END];
    stp_store_directory directory;
    stp_store_summary summary; ///< its parts are the table's
    stp_store_method* methods; ///< of the directory
    uint32_t* method_sets;     ///< of all methods but the first: by method, then by node
    /// Of each octave, then of each point set, the record of its block of attributes; STP_STORE_NONE: it has none. NULL: there
    /// are none in the file.
    uint32_t* attribute_blocks;
    stp_store_coloring coloring;
    bool objects_ready;
    bool partial;           ///< opened for its summary: the graph and what hangs on it was not read
    uint8_t* pages_checked; ///< a bit for each page of the sections that are not packed
    bool page_table_checked;
    uint64_t bytes_checked;           ///< of the directory
    struct stp_store_key_table* keys; ///< made when first asked for
    struct stp_store_large**
        large;         ///< of each mesh, its large triangles; made when first asked for
    uint64_t arrivals; ///< of bulk data, in all its residencies
    struct stp_residency* residency; ///< what loads bulk data; NULL: it is used as it is mapped
};

static inline stp_store_judge stp_store_own_judge(const stp_store* store)
{
    return (stp_store_judge){
        .context = store->context, .path = store->path, .failure = STP_ERROR_FORMAT};
}

/// CRC-32 of some bytes, as zlib computes it; chained by passing the value so far, 0 at first.
uint32_t stp_store_crc(uint32_t crc, const void* bytes, size_t size);

/// Header and section table. Fills file_bytes, data_offset, sections and known.
STP_MUST_USE stp_result stp_store_read_header(stp_store* store);

/// Checks the checksum of a section.
STP_MUST_USE stp_result stp_store_verify_section(stp_store* store,
                                                 const stp_store_section* section);
/// The checked texts of a section; empty where there is none.
STP_MUST_USE stp_result stp_store_read_text(stp_store* store, uint32_t type, stp_store_text* text);
/// Checks the pages that a text of a section of texts lies in, and its use (stp_store_use_text). NULL is right.
/// @return STP_OK, FORMAT, OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_store_verify_text(stp_store* store, uint32_t type, stp_store_text* uses,
                                              const char* text);
/// Decodes the records of a section into `tables` and `counts`.
STP_MUST_USE stp_result stp_store_read_table(stp_store* store, uint32_t type, stp_store_text* text);
/// Summary and scene parts, decoded already.
STP_MUST_USE stp_result stp_store_judge_summary(stp_store* store);
/// Reads what an opening for the summary alone reads, instead of the directory.
STP_MUST_USE stp_result stp_store_read_head(stp_store* store);
/// Checks more of what stp_store_read_head leaves unread: some pages of each section.
STP_MUST_USE stp_result stp_store_check_head(stp_store* store);

/// Checks the pages of a section that hold some of its bytes, once each. Files without checksums of pages: the
/// whole section.
STP_MUST_USE stp_result stp_store_verify_range(stp_store* store, const stp_store_section* section,
                                               uint64_t offset, uint64_t size);
/// Where the records of a section begin. Of a packed one, pages are there once stp_store_verify_range asked for them.
STP_MUST_USE stp_result stp_store_find_content(stp_store* store, const stp_store_section* section,
                                               const unsigned char** content);

// Packed sections.
/// Checks the table of pages, once; before any of its pages is read.
STP_MUST_USE stp_result stp_store_open_packed(stp_store* store, const stp_store_section* section);
/// Bytes of a page, decoded.
size_t stp_store_page_size(const stp_store_section* section, uint64_t page);
/// Checks and decodes a page into `out`.
STP_MUST_USE stp_result stp_store_read_page(stp_store* store, const stp_store_section* section,
                                            uint64_t page, void* out);
/// Checks the table and at most so many pages, and keeps nothing.
STP_MUST_USE stp_result stp_store_check_packed(stp_store* store, const stp_store_section* section,
                                               uint64_t pages);
/// Decodes the pages that hold some bytes of the content, once each.
STP_MUST_USE stp_result stp_store_unpack_range(stp_store* store, const stp_store_section* section,
                                               uint64_t offset, uint64_t size);
void stp_store_free_packed(stp_store* store);

/// Checks the table of the pages' checksums itself, once.
STP_MUST_USE stp_result stp_store_verify_page_table(stp_store* store);

/// What the summary says against what the file holds.
STP_MUST_USE stp_result stp_store_check_summary(stp_store* store);

/// Frees the table of keys.
void stp_store_free_keys(stp_store* store);

/// Fits octaves, breakpoints and blocks to the sets, meshes, point sets and textures they belong
/// to.
STP_MUST_USE stp_result stp_store_link_blocks(stp_store* store);

/// Leaves the first `octave_count` octaves of a set, and what of its tables holds for them.
void stp_store_cut_surfels(stp_splats* surfels, uint32_t octave_count);

/// Memory that the columns of so many octaves take when joined.
uint64_t stp_store_columns_bytes(const stp_splats* surfels, uint32_t octave_count);
/// Takes it for all octaves of a (cut) set, and points its columns there. NULL where memory runs out, not logged.
stp_store_joined* stp_store_reserve_columns(stp_context* context, stp_splats* surfels);
/// Copies so many octaves from other columns of the same set.
void stp_store_copy_columns(const stp_splats* surfels, const stp_splats* before,
                            uint32_t octave_count);
/// Groups of so many splats.
static inline uint64_t stp_store_group_count(uint64_t splats)
{
    return (splats + STP_GROUP_SPLATS - 1) / STP_GROUP_SPLATS;
}

/// Makes the groups of a set with ranges that splats [first, end) are in; those before `end` are there.
void stp_store_make_groups(const stp_splats* surfels, uint32_t first, uint32_t end);

/// Checks an octave's block and puts its columns in their places. The octaves before it are there.
STP_MUST_USE stp_result stp_store_add_octave(stp_store* store, uint32_t index, uint32_t octave,
                                             const stp_splats* surfels);
/// Whether any of the first octaves of a set is coded as operators.
bool stp_store_has_operators(const stp_store* store, uint32_t index, uint32_t octave_count);

/// Where in a set's columns those of an octave's block belong.
void stp_store_octave_targets(const stp_splats* surfels, uint32_t octave,
                              void* targets[STP_SURFEL_COLUMNS]);
/// Makes columns the set's own; what it had is the caller's.
void stp_store_set_columns(stp_store_surfels_record* record, stp_store_joined* joined,
                           const stp_splats* columns, uint32_t octave_count);

// Pointers into a block's bytes. Nothing is checked, but clusters: @return what is wrong with them, or NULL.
void stp_store_find_mesh_columns(uint32_t present, const unsigned char* bytes,
                                 stp_store_mesh* mesh);
void stp_store_find_point_columns(uint32_t present, const unsigned char* bytes,
                                  stp_store_point_set* points);
const char* stp_store_find_clusters(const stp_store* store, uint32_t index,
                                    const unsigned char* bytes, stp_clusters* clusters);

/// Checks how certain sets are, which is decoded already.
STP_MUST_USE stp_result stp_store_judge_certainty(const stp_store* store);
/// The same where the sets are read: gives it to them.
STP_MUST_USE stp_result stp_store_link_certainty(stp_store* store);

/// Reads which methods the sets are of, before blocks are linked. Files that do not say have sets of `blue` alone.
STP_MUST_USE stp_result stp_store_read_methods(stp_store* store, stp_store_text* text);
/// The methods alone, of a store opened for its summary.
STP_MUST_USE stp_result stp_store_read_method_names(stp_store* store, stp_store_text* text);

/// Reads figures of attributes and coordinate systems; the sources are there.
STP_MUST_USE stp_result stp_store_read_figures(stp_store* store, stp_store_text* text);
/// Fits blocks of attributes to their owners, which are linked.
STP_MUST_USE stp_result stp_store_link_attributes(stp_store* store);
/// The block of attributes of an octave or point set, read from the mapped file; without a block where it has none here.
stp_store_values stp_store_values_of(const stp_store* store, uint32_t kind, uint32_t owner,
                                     uint32_t octave);
/// Whether colours or coverages are not the file's own.
bool stp_store_is_colored(const stp_store* store);
/// Drops what memory was made for points: they are read again when they are asked for.
void stp_store_release_points(stp_store* store);
/// Gives a point record the columns of the set that holds its points, in memory that the record owns.
/// @return STP_OK; STP_ERROR_TRUNCATED, and as stp_store_get_surfels
STP_MUST_USE stp_result stp_store_make_held_points(stp_store* store, uint32_t index,
                                                   stp_store_point_record* record);

/// Puts a store's own colours and marks in the place of those of an octave that was just read; the octaves before are there.
/// `source` tells how the file is read. Nothing is done where points are not coloured. @return as stp_store_read_chunks
const char* stp_store_color_octave(const stp_store* store, uint32_t index, uint32_t octave,
                                   const stp_splats* surfels, const stp_store_block_source* source,
                                   uint64_t* read_bytes);
/// Makes the colours of a point set, 4 bytes each, from those it has (NULL: white).
const char* stp_store_color_points(const stp_store* store, uint32_t index, const uint8_t* colors,
                                   const stp_store_block_source* source, uint8_t* colored,
                                   uint64_t* read_bytes);
/// Checks all that a block of attributes holds.
STP_MUST_USE stp_result stp_store_check_values(stp_store* store, const stp_store_block* block);

typedef struct stp_store_large stp_store_large;
/// Frees the lists of large triangles.
void stp_store_free_large(stp_store* store);

/// Frees the columns of a set.
void stp_store_free_columns(stp_context* context, stp_store_surfels_record* record);

/// Whether the file holds all of a block; false only where it was cut short.
bool stp_store_is_block_here(const stp_store* store, const stp_store_block* block);
/// The entry of the block table.
const stp_store_block* stp_store_block_at(const stp_store* store, uint32_t index);
/// Says that there is no such mesh, ...: STP_ERROR_ARGUMENT.
stp_result stp_store_fail_index(const stp_store* store, const char* what, uint32_t index);
/// The block of a set's octave.
const stp_store_block* stp_store_octave_block(const stp_store* store, uint32_t index,
                                              uint32_t octave);
/// Reads a part of the mapped file (stp_store_block_source); `user` is the store.
bool stp_store_read_mapped(void* user, uint64_t offset, void* bytes, size_t size);
/// Says that something of a block is wrong, or that it is not there: STP_ERROR_FORMAT, STP_ERROR_TRUNCATED.
stp_result stp_store_fail_block(const stp_store* store, const stp_store_block* block,
                                const char* what);
/// Checks that a block is there, whole and right, and gives its first byte.
STP_MUST_USE stp_result stp_store_verify_block(const stp_store* store, const stp_store_block* block,
                                               const unsigned char** bytes);
