// SPDX-License-Identifier: MIT
//
// Enlarges a picture that was drawn at a lower resolution: colours bilinearly, nearness by the
// nearest pixel. Integer arithmetic: the same bits everywhere.
#pragma once

#include "draw/draw.h"

/// The four bytes of a pixel, with room for products.
typedef uint16_t stp_enlarged_channels __attribute__((vector_size(8)));

/// Pixels between which a column lies, and their shares of it, in 256ths.
typedef struct stp_enlarged_column {
    stp_enlarged_channels shares[2];
    uint32_t left, right;
} stp_enlarged_column;

/// Memory of a renderer for its smaller pictures. Zero-initialize it.
typedef struct stp_enlargement {
    uint8_t* pixels; ///< of the smaller picture
    size_t pixel_capacity;
    float* nearness; ///< of the larger one
    size_t nearness_capacity;
    stp_enlarged_column* columns; ///< of an eye of the larger one
    size_t column_capacity;
    bool is_used;         ///< the last picture was enlarged:
    stp_view small, view; ///< its views
    bool has_nearness;    ///< `nearness` is of it
} stp_enlargement;

/// The view of a picture at a share of a view's resolution, above 0 and below 1: at least a pixel
/// each way for each eye.
stp_view stp_enlarge_view(const stp_view* view, double share);

/// Makes room for a picture of a smaller view. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_enlarge_begin(stp_context* context, const stp_view* small,
                                          stp_enlargement* e, stp_image* image);

/// Enlarges a smaller picture, with `eyes` side by side. @return STP_OK, STP_ERROR_OUT_OF_MEMORY
/// (logged)
STP_MUST_USE stp_result stp_enlarge_picture(stp_context* context, stp_enlargement* e,
                                            const stp_image* small, uint32_t eyes,
                                            stp_image* image);

/// The nearness of a smaller view's pixels, eye by eye, for those of a view. @return owned by `e`;
/// NULL if out of memory
const float* stp_enlarge_nearness(stp_context* context, stp_enlargement* e, const stp_view* small,
                                  const float* nearness, const stp_view* view);

void stp_enlargement_destroy(stp_context* context, stp_enlargement* e);
