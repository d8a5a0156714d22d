// SPDX-License-Identifier: MIT
// Splat sets, point sets, attributes and leaves of an open file, for those who open, check and load
// them.
#pragma once

#include "store/bytes/chunks.h"
#include "store/bytes/values.h"
#include "store/file/content.h"
#include "store/file/store_state.h"

/// Links octaves, breakpoints and blocks to their sets, meshes, point sets and textures.
STP_MUST_USE stp_result stp_store_link_blocks(stp_store* store);

/// Truncates a set to its first `octave_count` octaves, and its tables accordingly.
void stp_store_truncate_splat_set(stp_splats* splats, uint32_t octave_count);

/// Size of the joined columns of this many octaves.
uint64_t stp_store_columns_bytes(const stp_splats* splats, uint32_t octave_count);
/// Allocates the columns for all octaves of a (truncated) set. NULL if memory runs out, not logged.
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

/// The block of a set's octave.
const stp_store_block* stp_store_octave_block(const stp_store* store, uint32_t index,
                                              uint32_t octave);

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

// Methods of content to be written.

/// Whether the file must list its methods: it has others than `blue`.
bool stp_store_lists_methods(const stp_store_directory* directory);

/// The methods of the content, and the columns of their sets.
STP_MUST_USE stp_result stp_store_validate_methods(const stp_store_validator* validator,
                                                   const stp_store_content* content);

// Leaves.

/// The block of a set's leaves; NULL if it has none.
const stp_store_block* stp_store_leaves_block(const stp_store* store, uint32_t set);
/// Size of this many leaves with their tree.
uint64_t stp_store_leaves_bytes(uint32_t leaf_count);
/// Builds the tree of a set's leaves; the leaves are at the beginning of its memory. Any thread.
/// @return NULL, or the error in the leaves
const char* stp_store_open_leaves(const stp_store* store, uint32_t set, void* memory,
                                  stp_store_leaves* leaves);
/// Sets the result of stp_store_get_leaves; NULL: no leaves.
void stp_store_publish_leaves(const stp_store* store, uint32_t set, const stp_store_leaves* leaves);
/// Frees the leaves loaded by a store without a residency.
void stp_store_release_leaves(stp_store* store);
