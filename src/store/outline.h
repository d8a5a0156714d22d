// SPDX-License-Identifier: MIT
//
// The tree of a scene's objects as people see it: names, ids, what is below what, and where. Made for scenes of tens of
// millions of objects: records and texts are read out of the mapped file when somebody asks for them, and nothing is
// copied but one number an object, by which children are found. That is made in pieces, between frames.
//
//   file: objects in any order, each with its parent     order: the same, sorted by parent: children are a range of it
//
// An *item* is an object as it stands in the scene. What is below a prototype is an item wherever that is used.
#pragma once

#include "store/store.h"

enum { STP_OUTLINE_DEPTH = 64 };

typedef struct stp_outline stp_outline;

/// An object in its place.
typedef struct stp_outline_item {
    uint32_t depth;                      ///< objects on the way; 0: the whole scene
    uint32_t objects[STP_OUTLINE_DEPTH]; ///< from the uppermost one to the item's own
    uint32_t node;                       ///< STP_STORE_NONE: nothing is to be seen of it
    stp_affine transform;                ///< to scene space
} stp_outline_item;

/// What a row shows of an item.
typedef struct stp_outline_row {
    const char* name; ///< NULL: none. Texts live as long as the store
    const char* id;
    uint64_t triangle_count, point_count;
    stp_boxd bounds; ///< scene space; empty where there is no node
    uint64_t child_count;
} stp_outline_row;

/// Nothing is read yet. Of a store opened whole or with its objects deferred.
STP_MUST_USE stp_result stp_outline_create(stp_context* context, stp_store* store,
                                           stp_outline** outline);
void stp_outline_destroy(stp_outline* outline);

/// Objects that the file has.
uint32_t stp_outline_object_count(const stp_outline* outline);

/// Goes on with what must be known before anything else can be asked, at most `records` of it (0: all).
/// @return STP_OK, STP_ERROR_FORMAT (damaged records), STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_outline_prepare(stp_outline* outline, uint64_t records, bool* ready);

// Everything below needs a outline that is ready, and returns as stp_outline_prepare does.

/// The whole scene.
stp_outline_item stp_outline_root(const stp_outline* outline);
/// Children `first` to `first + room` - 1 of an item, in the order of the file; `count` says how many were given.
STP_MUST_USE stp_result stp_outline_children(stp_outline* outline, const stp_outline_item* item,
                                             uint64_t first, uint32_t room, stp_outline_item* items,
                                             uint32_t* count);
STP_MUST_USE stp_result stp_outline_describe(stp_outline* outline, const stp_outline_item* item,
                                             stp_outline_row* row);
/// Names from the top, with slashes between them ("#7" for object 7 without a name), cut to `size` bytes with the zero byte,
/// between characters of UTF-8; ".../" is before those of an item whose uppermost objects it has no room for.
STP_MUST_USE stp_result stp_outline_path(stp_outline* outline, const stp_outline_item* item,
                                         char* text, size_t size);
/// Where an object stands. One below a prototype stands nowhere by itself: its node is STP_STORE_NONE. Of one with more
/// objects above it than an item has room for, the item has the lowest.
STP_MUST_USE stp_result stp_outline_item_of(stp_outline* outline, uint32_t object,
                                            stp_outline_item* item);

/// The item with a path (as stp_outline_path gives it): of several the one the middle of whose box is nearest to `near`, or
/// the first (NULL). `found` false: there is none.
STP_MUST_USE stp_result stp_outline_by_path(stp_outline* outline, const char* path,
                                            const stp_vec3d* near, stp_outline_item* item,
                                            bool* found);

/// The lowest item to which a part at a place belongs: what was picked there (select/pick.h). `item->depth` 0: none is.
/// Where objects coincide, the first.
STP_MUST_USE stp_result stp_outline_find(stp_outline* outline, stp_store_part part,
                                         const stp_affine* transform, stp_outline_item* item);

/// A search, one at a time and outline; goes on where it was.
typedef struct stp_outline_search {
    char text[256];   ///< what names or ids must contain, whatever the case of letters
    uint32_t next;    ///< the object to look at next; all were where it is the count of objects
    uint32_t matches; ///< so far
} stp_outline_search;

/// A text longer than 255 bytes is cut.
stp_outline_search stp_outline_search_begin(const char* text);
/// Looks at up to `records` objects, and gives those whose name or id contains the text, at most `room` of them.
STP_MUST_USE stp_result stp_outline_search_on(stp_outline* outline, stp_outline_search* search,
                                              uint32_t records, uint32_t room, uint32_t* objects,
                                              uint32_t* count);

/// Whether an object is what a text says: its name, the end of its path ("house/door"), its id, or "#" and its number.
STP_MUST_USE stp_result stp_outline_is_named(stp_outline* outline, uint32_t object,
                                             const char* text, bool* named);
