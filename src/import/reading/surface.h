// SPDX-License-Identifier: MIT
// Materials and pictures of imported surfaces: a plain material for formats without materials,
// values of colours, and pictures that files name or contain.
#pragma once

#include "image/image_codecs.h"
#include "import/reading/import.h"
#include "import/reading/lookup.h"
#include "scene/scene.h"

/// The material of formats without materials: white, rough, not metallic, and double-sided, because
/// triangles in such files may have any winding.
stp_material stp_material_plain(void);

/// Adds the plain material once; later calls return the same index in `*index` (initially
/// STP_NONE).
STP_MUST_USE stp_result stp_add_plain_material(stp_import* import, uint32_t* index);

/// Decodes an sRGB value of any precision; NaN is 0, others are clamped to 0..1.
float stp_srgb_to_linear(float value);
/// 0..1 linear to 65535ths; clamped, NaN is 0.
uint16_t stp_unorm16(float value);
/// 0..1 to 255ths; clamped, NaN is 0.
uint8_t stp_unorm8(float value);

/// Sets the axes of a format without axes: the caller's choice, else `up`.
void stp_import_default_axes(stp_import* import, char up);

/// The pictures that a file names, each read once.
typedef struct stp_pictures {
    stp_import* import;
    stp_lookup known;
} stp_pictures;

stp_pictures stp_pictures_create(stp_import* import);
void stp_pictures_destroy(stp_pictures* pictures);

/// Reads the picture that `reference` names as a texture. Drive letters and absolute paths are
/// dropped: the picture is searched beside the file. A missing or unsupported picture causes a
/// warning that begins with `place`, and STP_NONE. @return STP_OK; STP_ERROR_OUT_OF_MEMORY,
/// STP_ERROR_IO (logged)
STP_MUST_USE stp_result stp_pictures_read(stp_pictures* pictures, const char* place,
                                          const char* reference, stp_wrap wrap, uint32_t* texture);

/// Decodes a picture that stp_image_measure accepted, and keeps the original bytes. Fills width,
/// height, texels and the encoded picture of `texture`. Does not log, so jobs may call it. @return
/// STP_OK, STP_ERROR_FORMAT (`info` has the reason), STP_ERROR_OUT_OF_MEMORY
STP_MUST_USE stp_result stp_picture_decode_kept(stp_context* context, const unsigned char* bytes,
                                                size_t size, stp_image_info* info,
                                                stp_texture* texture);

/// Decodes a picture into `texture`; an unreadable one causes a warning about `place`, with *read
/// false. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_picture_decode(stp_import* import, const char* place,
                                           const unsigned char* bytes, size_t size,
                                           stp_texture* texture, bool* read);

// Picture formats of older programs, used by OBJ, 3DS, DAE and FBX files: TGA and BMP.

/// Decodes TGA (mapped, true colour and grey, plain or run-length) or BMP (1 to 32 bits,
/// uncompressed) to RGBA, with stb_image. Fills width, height and texels of `texture`. Does not log;
/// on failure `*reason` explains why. Memory is at most 450 times the size of the file.
/// @return STP_OK, STP_ERROR_UNSUPPORTED, STP_ERROR_TRUNCATED, STP_ERROR_OUT_OF_MEMORY
STP_MUST_USE stp_result stp_image_decode_plain(stp_context* context, const unsigned char* bytes,
                                               size_t size, stp_texture* texture,
                                               const char** reason);
