// SPDX-License-Identifier: MIT
// A model as the files of this room see it: an opened file, and what is made for it when it is first needed.
#pragma once

#include "base/context.h"
#include "base/desc.h"
#include "select/visibility.h"
#include "store/outline.h"
#include "store/residency.h"

#include <stipple/model.h>

/// Bytes of a file that does not lie on a disk.
typedef struct stp_model_source {
    void* copy;     ///< the whole file, from stp_alloc; NULL: none
    void* reserved; ///< address space of the file's size that holds its directory alone; NULL: none
    size_t size;    ///< of the file
    uint64_t counted; ///< bytes of `reserved` that count as memory
    stp_read_callback read;
    void* read_user;
} stp_model_source;

struct stp_model {
    stp_context* context;
    stp_store* store;
    stp_model_source source;
    stp_store_summary summary;
    bool owns_summary;          ///< the file has none: it was counted
    stp_residency* residency;   ///< NULL: does not stream
    stp_outline* outline;       ///< NULL: not needed yet
    stp_visibility* visibility; ///< NULL: all is shown
};

/// Opens the store of a model from the caller's memory or callback. After a failure the source is still to be destroyed.
STP_MUST_USE stp_result stp_model_open_source(stp_model* model, const stp_model_desc* desc,
                                              const stp_store_open_desc* opening);
/// After the store was closed.
void stp_model_source_destroy(stp_context* context, stp_model_source* source);
/// For stp_residency_desc: `user` is the source.
bool stp_model_source_read(void* user, uint64_t offset, void* bytes, size_t size);

/// The tree of objects, ready.
STP_MUST_USE stp_result stp_model_use_outline(stp_model* model, stp_outline** outline);
/// An object in its place. Says where there is no such object: STP_ERROR_ARGUMENT.
STP_MUST_USE stp_result stp_model_find_item(stp_model* model, uint32_t object,
                                            stp_outline_item* item);
/// Whether an item stands in the scene by itself.
static inline bool stp_model_is_placed(const stp_outline_item* item)
{
    return item->depth > 0 && item->node != STP_STORE_NONE;
}

/// Reads a descriptor of type `type`, and says where it sets fields that this library lacks.
#define STP_READ_DESC(context, type, desc, given)                                                  \
    (stp_desc_read((desc), sizeof(type), sizeof(type), (given))                                    \
         ? STP_OK                                                                                  \
         : stp_fail((context), STP_ERROR_UNSUPPORTED,                                              \
                    #type ": sets fields that this version of the library lacks"))
#define STP_WRITE_INFO(info, made) stp_info_write((info), &(made), sizeof(made), sizeof(made))
