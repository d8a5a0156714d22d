// SPDX-License-Identifier: MIT
// Pictures in memory: PNG (libspng), JPEG (libjpeg-turbo) and WebP (libwebp), detected by content.
// All input is untrusted: the size that a header claims is checked before allocation.
#pragma once

#include "base/core/context.h"

#include <stipple/image.h>

/// The numbers of PNG, JPEG and WebP are also those of `.stip` files (docs/format.md, Texture).
typedef enum stp_image_kind {
    STP_IMAGE_UNKNOWN,
    STP_IMAGE_PNG,
    STP_IMAGE_JPEG,
    STP_IMAGE_WEBP,
    STP_IMAGE_KTX2, ///< recognised, not decoded
} stp_image_kind;

enum { STP_IMAGE_REASON_SIZE = 160 };

/// Content of a picture's header, and the reason if it cannot be decoded.
typedef struct stp_image_info {
    stp_image_kind kind;
    uint32_t width, height;
    char reason[STP_IMAGE_REASON_SIZE]; ///< set if a call below fails
} stp_image_info;

/// Whether a claimed pixel count is plausible for a compressed size, for one picture or all
/// pictures of a model: always up to 2^26 pixels, above that at most 260 pixels per byte.
bool stp_image_is_plausible(uint64_t pixels, uint64_t bytes);

/// Reads the header only. Refuses pictures of more than 2^28 pixels and implausible ones
/// (stp_image_is_plausible). Logs nothing.
/// @return STP_OK, STP_ERROR_FORMAT, STP_ERROR_UNSUPPORTED, STP_ERROR_LIMIT,
///         STP_ERROR_OUT_OF_MEMORY
STP_MUST_USE stp_result stp_image_measure(const unsigned char* bytes, size_t size,
                                          stp_image_info* info);

/// Upper bound on the memory that decoding takes besides the texels. Uses kind, width and height of
/// `info`.
uint64_t stp_image_decoder_bytes(const stp_image_info* info, const unsigned char* bytes,
                                 size_t size);

/// Decodes a picture that stp_image_measure accepted to width x height x 4 bytes of RGBA. The
/// caller counts the decoder's memory (stp_image_decoder_bytes). Logs nothing, so jobs may call it;
/// `info` has the reason.
/// @return STP_OK, STP_ERROR_FORMAT, STP_ERROR_OUT_OF_MEMORY
STP_MUST_USE stp_result stp_image_decode_into(const unsigned char* bytes, size_t size,
                                              stp_image_info* info, uint8_t* texels);

/// Decodes into memory of `context` (stp_alloc), within its limit. Logs nothing.
STP_MUST_USE stp_result stp_image_decode_measured(stp_context* context, const unsigned char* bytes,
                                                  size_t size, stp_image_info* info,
                                                  stp_image* image);

/// Combines stp_image_measure and stp_image_decode_measured. `name` begins the error message.
STP_MUST_USE stp_result stp_image_decode(stp_context* context, const char* name,
                                         const unsigned char* bytes, size_t size, stp_image* image);

/// Compression effort.
typedef enum stp_image_effort {
    STP_IMAGE_FAST,  ///< RGBA at a low level: for rendered pictures
    STP_IMAGE_SMALL, ///< fewest channels that hold the picture, at a higher level: for stored files
} stp_image_effort;

/// Lossless PNG; the same bytes for the same picture. The caller frees the bytes (stp_free). Logs
/// nothing.
/// @return STP_OK, STP_ERROR_FORMAT (a picture without pixels, or too large for PNG),
///         STP_ERROR_OUT_OF_MEMORY
STP_MUST_USE stp_result stp_image_encode_png(stp_context* context, const stp_image* image,
                                             stp_image_effort effort, unsigned char** bytes,
                                             size_t* size);
