// SPDX-License-Identifier: MIT
//
// The tree of a scene's objects for display: names, ids, children, positions. It scales to tens of
// millions of objects: records and texts are read from the mapped file on request, and the only
// copy is one index per object, for finding children. That index is built in slices, between
// frames.
//
//   file    objects, each after its parent
//   order   sorted by parent, so children are a range
//
// An *item* is an object as it occurs in the scene. Objects below a prototype are items wherever
// the prototype is used.
#pragma once

#include "store/file/store.h"

enum { STP_OUTLINE_DEPTH = 64 };

typedef struct stp_outline stp_outline;

/// An occurrence of an object.
typedef struct stp_outline_item {
    uint32_t depth;                      ///< number of objects on the path; 0: the whole scene
    uint32_t objects[STP_OUTLINE_DEPTH]; ///< from the topmost object to the item's own
    uint32_t node;                       ///< STP_STORE_NONE: it has nothing visible
    stp_affine transform;                ///< to scene space
} stp_outline_item;

/// The content of an item's row.
typedef struct stp_outline_row {
    const char* name; ///< NULL: none. The store owns texts
    const char* id;
    uint64_t triangle_count, point_count;
    stp_boxd bounds; ///< scene space; empty without a node
    uint64_t child_count;
} stp_outline_row;

/// Reads nothing yet. The store must be opened in full; its objects may be deferred.
STP_MUST_USE stp_result stp_outline_create(stp_context* context, stp_store* store,
                                           stp_outline** outline);
void stp_outline_destroy(stp_outline* outline);

/// Number of objects in the file.
uint32_t stp_outline_object_count(const stp_outline* outline);

/// Builds the index, at most `records` records per call (0: all). Everything else requires it to be
/// ready. @return STP_OK, STP_ERROR_FORMAT (damaged records), STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_outline_prepare(stp_outline* outline, uint64_t records, bool* ready);

// The functions below need an outline that is ready, and return as stp_outline_prepare does.

/// The whole scene.
stp_outline_item stp_outline_root(const stp_outline* outline);
/// Children [first, first + room) of an item, in file order; `count` is the number returned.
STP_MUST_USE stp_result stp_outline_children(stp_outline* outline, const stp_outline_item* item,
                                             uint64_t first, uint32_t room, stp_outline_item* items,
                                             uint32_t* count);
STP_MUST_USE stp_result stp_outline_describe(stp_outline* outline, const stp_outline_item* item,
                                             stp_outline_row* row);
/// Names from the top with slashes between them ("#7" for object 7 without a name), zero-terminated
/// and cut to `size` bytes between UTF-8 characters. A path too deep for an item starts with
/// ".../".
STP_MUST_USE stp_result stp_outline_path(stp_outline* outline, const stp_outline_item* item,
                                         char* text, size_t size);
/// The item of an object. Below a prototype, an object has no position of its own: its node is
/// STP_STORE_NONE. If the path is deeper than an item can hold, the item keeps the lowest objects.
STP_MUST_USE stp_result stp_outline_item_of(stp_outline* outline, uint32_t object,
                                            stp_outline_item* item);

/// Finds an item by its path (see stp_outline_path). Among several, chooses the one whose box
/// centre is nearest to `near`, or the first if `near` is NULL. `found` is false if there is none.
STP_MUST_USE stp_result stp_outline_by_path(stp_outline* outline, const char* path,
                                            const stp_vec3d* near, stp_outline_item* item,
                                            bool* found);

/// The lowest item that contains a picked part (select/pick_ray.h) at a transform. `item->depth` is
/// 0 if there is none. Among coinciding objects, the first.
STP_MUST_USE stp_result stp_outline_find(stp_outline* outline, stp_store_part part,
                                         const stp_affine* transform, stp_outline_item* item);

/// A search, one per outline at a time; each call continues it.
typedef struct stp_outline_search {
    char text[256];   ///< text to find in names or ids, ignoring case
    uint32_t next;    ///< the next object to examine; the object count when done
    uint32_t matches; ///< found so far
} stp_outline_search;

/// Texts longer than 255 bytes are cut.
stp_outline_search stp_outline_search_begin(const char* text);
/// Examines up to `records` objects. Returns those whose name or id contains the text, at most
/// `room`.
STP_MUST_USE stp_result stp_outline_search_on(stp_outline* outline, stp_outline_search* search,
                                              uint32_t records, uint32_t room, uint32_t* objects,
                                              uint32_t* count);

/// Whether a text names an object: by its name, the end of its path ("house/door"), its id, or "#"
/// and its index.
STP_MUST_USE stp_result stp_outline_is_named(stp_outline* outline, uint32_t object,
                                             const char* text, bool* named);
