// SPDX-License-Identifier: MIT
// Internals of a model: an opened file, and data created on first use.
#pragma once

#include "base/core/context.h"
#include "base/core/desc.h"
#include "select/visibility.h"
#include "store/outline/outline.h"
#include "store/residency/residency.h"

#include <stipple/model.h>

/// Bytes of a file that is not on disk.
typedef struct stp_model_source {
    void* copy;     ///< the whole file, from stp_alloc; NULL: none
    void* reserved; ///< address space of the file's size that holds only its directory; NULL: none
    size_t size;    ///< bytes of the whole file
    uint64_t counted; ///< bytes of `reserved` that count as memory
    stp_read_callback read;
    void* read_user;
} stp_model_source;

struct stp_model {
    stp_context* context;
    stp_store* store;
    stp_model_source source;
    stp_store_summary summary;
    bool owns_summary;          ///< the file stores no summary: computed on opening
    stp_residency* residency;   ///< NULL: no streaming
    stp_outline* outline;       ///< NULL: not needed yet
    stp_visibility* visibility; ///< NULL: everything is shown
};

/// Opens the store of a model from the caller's memory or callback. The source must be destroyed
/// even after a failure.
STP_MUST_USE stp_result stp_model_open_source(stp_model* model, const stp_model_desc* desc,
                                              const stp_store_open_desc* opening);
/// Call after closing the store.
void stp_model_source_destroy(stp_context* context, stp_model_source* source);
/// For stp_residency_desc: `user` is the source.
bool stp_model_source_read(void* user, uint64_t offset, void* bytes, size_t size);

/// Returns the object tree, built on first use.
STP_MUST_USE stp_result stp_model_use_outline(stp_model* model, stp_outline** outline);
/// Whether an item itself is placed in the scene.
static inline bool stp_model_is_placed(const stp_outline_item* item)
{
    return item->depth > 0 && item->node != STP_STORE_NONE;
}

/// Whether a call has its object (a model or a builder) and a pointer that it needs. @return STP_OK
/// or STP_ERROR_ARGUMENT (logged if the object is there)
#define STP_CHECK_CALL(object, pointer)                                                            \
    ((object) != NULL ? STP_CHECK_POINTER((object)->context, (pointer)) : STP_ERROR_ARGUMENT)

/// Reads a descriptor of type `type`, and logs if it sets fields that this library lacks.
#define STP_READ_DESC(context, type, desc, given)                                                  \
    (stp_desc_read((desc), sizeof(type), sizeof(type), (given))                                    \
         ? STP_OK                                                                                  \
         : stp_fail((context), STP_ERROR_UNSUPPORTED,                                              \
                    #type ": sets fields that this version of the library lacks"))
#define STP_WRITE_INFO(info, made) stp_info_write((info), &(made), sizeof(made), sizeof(made))
