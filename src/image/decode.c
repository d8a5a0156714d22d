// SPDX-License-Identifier: MIT
#include "image/image_codecs.h"

#include <assert.h>
#include <spng.h>
#include <stdio.h>
#include <string.h>
#include <turbojpeg.h>
#include <webp/decode.h>

#define PIXEL_LIMIT ((uint64_t)1 << 28)

// Above 2^26 pixels (256 MiB of RGBA), a picture must not claim more than 260 pixels per byte. A
// PNG of one RGBA colour has 258, photographs and drawings below 100; palettes reach thousands.
#define PIXELS_ALWAYS_BELIEVED ((uint64_t)1 << 26)
#define PIXELS_PER_BYTE 260

// Decoder memory besides the picture, in bytes per pixel: row buffers; the coefficients of a
// progressive JPEG, three channels of 16 bits; the colours, or the alpha, of a whole WebP picture.
#define ROW_BYTES_PER_PIXEL 64u
#define COEFFICIENT_BYTES 6u
#define WEBP_BYTES 5u

static const unsigned char png_signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
static const unsigned char ktx2_signature[8] = {0xAB, 'K', 'T', 'X', ' ', '2', '0', 0xBB};

static stp_image_kind detect_kind(const unsigned char* bytes, size_t size)
{
    if (size >= 8 && memcmp(bytes, png_signature, 8) == 0) {
        return STP_IMAGE_PNG;
    }
    if (size >= 3 && bytes[0] == 0xFF && bytes[1] == 0xD8 && bytes[2] == 0xFF) {
        return STP_IMAGE_JPEG;
    }
    if (size >= 12 && memcmp(bytes, "RIFF", 4) == 0 && memcmp(bytes + 8, "WEBP", 4) == 0) {
        return STP_IMAGE_WEBP;
    }
    return size >= 8 && memcmp(bytes, ktx2_signature, 8) == 0 ? STP_IMAGE_KTX2 : STP_IMAGE_UNKNOWN;
}

static stp_result refuse(stp_image_info* info, stp_result result, const char* kind, const char* why)
{
    snprintf(info->reason, sizeof(info->reason), "%s picture: %.120s", kind, why);
    return result;
}

static stp_result open_png(const unsigned char* bytes, size_t size, stp_image_info* info,
                           spng_ctx** opened)
{
    spng_ctx* png = spng_ctx_new(0);
    if (png == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    struct spng_ihdr header;
    int error = spng_set_png_buffer(png, bytes, size);
    // limit text and profiles to a plausible size
    error = error != 0 ? error : spng_set_chunk_limits(png, (size_t)16 << 20, (size_t)64 << 20);
    error = error != 0 ? error : spng_get_ihdr(png, &header);
    if (error != 0) {
        spng_ctx_free(png);
        return refuse(info, STP_ERROR_FORMAT, "PNG", spng_strerror(error));
    }
    info->width = header.width;
    info->height = header.height;
    *opened = png;
    return STP_OK;
}

static stp_result measure_png(const unsigned char* bytes, size_t size, stp_image_info* info)
{
    spng_ctx* png;
    stp_result result = open_png(bytes, size, info, &png);
    if (result == STP_OK) {
        spng_ctx_free(png);
    }
    return result;
}

static stp_result decode_png(const unsigned char* bytes, size_t size, stp_image_info* info,
                             uint8_t* texels, size_t texel_size)
{
    spng_ctx* png;
    stp_result result = open_png(bytes, size, info, &png);
    if (result != STP_OK) {
        return result;
    }
    // 16-bit channels keep their upper byte
    int error = spng_decode_image(png, texels, texel_size, SPNG_FMT_RGBA8, SPNG_DECODE_TRNS);
    spng_ctx_free(png);
    if (error == SPNG_EMEM) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    return error == 0 ? STP_OK : refuse(info, STP_ERROR_FORMAT, "PNG", spng_strerror(error));
}

static stp_result open_jpeg(const unsigned char* bytes, size_t size, stp_image_info* info,
                            tjhandle* opened, int* color_space)
{
    tjhandle jpeg = tjInitDecompress();
    if (jpeg == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    int width = 0, height = 0, subsampling = 0;
    if (tjDecompressHeader3(jpeg, bytes, (unsigned long)size, &width, &height, &subsampling,
                            color_space) != 0 ||
        width <= 0 || height <= 0) {
        stp_result result = refuse(info, STP_ERROR_FORMAT, "JPEG", tjGetErrorStr2(jpeg));
        tjDestroy(jpeg);
        return result;
    }
    info->width = (uint32_t)width;
    info->height = (uint32_t)height;
    *opened = jpeg;
    return STP_OK;
}

static stp_result measure_jpeg(const unsigned char* bytes, size_t size, stp_image_info* info)
{
    tjhandle jpeg;
    int color_space;
    stp_result result = open_jpeg(bytes, size, info, &jpeg, &color_space);
    if (result == STP_OK) {
        tjDestroy(jpeg);
    }
    return result;
}

// Adobe writes CMYK inverted: 255 is no ink.
static void cmyk_to_rgba(uint8_t* texels, size_t texel_size)
{
    assert(texel_size % 4 == 0);
    for (size_t i = 0; i + 4 <= texel_size; i += 4) {
        unsigned black = texels[i + 3];
        for (size_t c = 0; c < 3; ++c) {
            texels[i + c] = (uint8_t)((texels[i + c] * black + 127) / 255);
        }
        texels[i + 3] = 255;
    }
}

static stp_result decode_jpeg(const unsigned char* bytes, size_t size, stp_image_info* info,
                              uint8_t* texels, size_t texel_size)
{
    tjhandle jpeg;
    int color_space;
    stp_result result = open_jpeg(bytes, size, info, &jpeg, &color_space);
    if (result != STP_OK) {
        return result;
    }
    bool is_cmyk = color_space == TJCS_CMYK || color_space == TJCS_YCCK;
    int error = tjDecompress2(jpeg, bytes, (unsigned long)size, texels, (int)info->width, 0,
                              (int)info->height, is_cmyk ? TJPF_CMYK : TJPF_RGBA,
                              TJFLAG_ACCURATEDCT | TJFLAG_LIMITSCANS);
    // many cameras write stray bytes, which is only a warning; a truncated picture is an error
    if (error != 0 && (tjGetErrorCode(jpeg) == TJERR_FATAL ||
                       strstr(tjGetErrorStr2(jpeg), "Premature end") != NULL)) {
        result = refuse(info, STP_ERROR_FORMAT, "JPEG", tjGetErrorStr2(jpeg));
    } else if (is_cmyk) {
        cmyk_to_rgba(texels, texel_size);
    }
    tjDestroy(jpeg);
    return result;
}

static stp_result measure_webp(const unsigned char* bytes, size_t size, stp_image_info* info)
{
    WebPBitstreamFeatures features;
    if (WebPGetFeatures(bytes, size, &features) != VP8_STATUS_OK || features.width <= 0 ||
        features.height <= 0) {
        return refuse(info, STP_ERROR_FORMAT, "WebP", "its header is damaged");
    }
    if (features.has_animation) {
        return refuse(info, STP_ERROR_UNSUPPORTED, "WebP", "it is animated");
    }
    info->width = (uint32_t)features.width;
    info->height = (uint32_t)features.height;
    return STP_OK;
}

static stp_result decode_webp(const unsigned char* bytes, size_t size, stp_image_info* info,
                              uint8_t* texels, size_t texel_size)
{
    if (WebPDecodeRGBAInto(bytes, size, texels, texel_size, (int)info->width * 4) == NULL) {
        return refuse(info, STP_ERROR_FORMAT, "WebP", "its data is damaged or truncated");
    }
    return STP_OK;
}

bool stp_image_is_plausible(uint64_t pixels, uint64_t bytes)
{
    return pixels <= PIXELS_ALWAYS_BELIEVED || pixels / PIXELS_PER_BYTE <= bytes;
}

stp_result stp_image_measure(const unsigned char* bytes, size_t size, stp_image_info* info)
{
    *info = (stp_image_info){.kind = detect_kind(bytes, size)};
    stp_result result = STP_OK;
    switch (info->kind) {
    case STP_IMAGE_PNG:
        result = measure_png(bytes, size, info);
        break;
    case STP_IMAGE_JPEG:
        result = measure_jpeg(bytes, size, info);
        break;
    case STP_IMAGE_WEBP:
        result = measure_webp(bytes, size, info);
        break;
    case STP_IMAGE_KTX2:
        return refuse(info, STP_ERROR_UNSUPPORTED, "KTX2", "this kind cannot be read");
    case STP_IMAGE_UNKNOWN:
        snprintf(info->reason, sizeof(info->reason), "%s",
                 size == 0 ? "the picture is empty" : "the picture is neither PNG, JPEG nor WebP");
        return STP_ERROR_UNSUPPORTED;
    }
    if (result != STP_OK) {
        return result;
    }
    uint64_t pixels = (uint64_t)info->width * info->height;
    if (pixels > PIXEL_LIMIT || !stp_image_is_plausible(pixels, size)) {
        snprintf(info->reason, sizeof(info->reason),
                 "the picture claims %u x %u pixels in %zu bytes", info->width, info->height, size);
        return STP_ERROR_LIMIT;
    }
    return STP_OK;
}

// Whether the decoder holds all coefficients of a JPEG picture: progressive ones, and those with
// several scans.
static bool has_many_scans(const unsigned char* bytes, size_t size)
{
    assert(size >= 3 && bytes[0] == 0xFF && bytes[1] == 0xD8 && "a JPEG file");
    size_t at = 2;
    unsigned components = UINT8_MAX;
    while (at + 10 <= size && bytes[at] == 0xFF) {
        unsigned marker = bytes[at + 1];
        if (marker == 0xC2 || marker == 0xC6 || marker == 0xCA || marker == 0xCE) {
            return true;
        }
        if (marker == 0xC0 || marker == 0xC1) { // the frame
            components = bytes[at + 9];
        }
        if (marker == 0xDA) { // the first scan
            return bytes[at + 4] < components;
        }
        bool alone = marker == 0xFF || marker == 0x01 || (marker >= 0xD0 && marker <= 0xD9);
        at += marker == 0xFF ? 1 : alone ? 2 : 2 + ((size_t)bytes[at + 2] << 8 | bytes[at + 3]);
    }
    return true; // unknown: assume the worst
}

// Memory that decoders allocate themselves: row buffers, windows and tables, and what grows with
// the picture.
uint64_t stp_image_decoder_bytes(const stp_image_info* info, const unsigned char* bytes,
                                 size_t size)
{
    uint64_t pixels = (uint64_t)info->width * info->height;
    uint64_t rows = ((uint64_t)64 << 10) + (uint64_t)info->width * ROW_BYTES_PER_PIXEL;
    switch (info->kind) {
    case STP_IMAGE_JPEG:
        return rows + (has_many_scans(bytes, size) ? pixels * COEFFICIENT_BYTES : 0);
    case STP_IMAGE_WEBP:
        return rows + pixels * WEBP_BYTES;
    default:
        return rows;
    }
}

stp_result stp_image_decode_into(const unsigned char* bytes, size_t size, stp_image_info* info,
                                 uint8_t* texels)
{
    assert(info->width > 0 && info->height > 0 && "stp_image_measure accepted it");
    assert(info->kind == STP_IMAGE_PNG || info->kind == STP_IMAGE_JPEG ||
           info->kind == STP_IMAGE_WEBP);
    size_t texel_size = (size_t)info->width * info->height * 4;
    switch (info->kind) {
    case STP_IMAGE_PNG:
        return decode_png(bytes, size, info, texels, texel_size);
    case STP_IMAGE_JPEG:
        return decode_jpeg(bytes, size, info, texels, texel_size);
    default:
        return decode_webp(bytes, size, info, texels, texel_size);
    }
}

stp_result stp_image_decode_measured(stp_context* context, const unsigned char* bytes, size_t size,
                                     stp_image_info* info, stp_image* image)
{
    assert((uint64_t)info->width * info->height <= PIXEL_LIMIT && "stp_image_measure accepted it");
    uint64_t own_bytes = stp_image_decoder_bytes(info, bytes, size);
    if (!stp_reserve(context, own_bytes)) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    uint8_t* texels = stp_alloc(context, (size_t)info->width * info->height * 4);
    stp_result result =
        texels != NULL ? stp_image_decode_into(bytes, size, info, texels) : STP_ERROR_OUT_OF_MEMORY;
    stp_release(context, own_bytes);
    if (result != STP_OK) {
        stp_free(context, texels);
        return result;
    }
    *image = (stp_image){.width = info->width, .height = info->height, .pixels = texels};
    return STP_OK;
}

stp_result stp_image_decode(stp_context* context, const char* name, const unsigned char* bytes,
                            size_t size, stp_image* image)
{
    stp_image_info info;
    stp_result result = stp_image_measure(bytes, size, &info);
    if (result == STP_OK) {
        result = stp_image_decode_measured(context, bytes, size, &info, image);
    }
    if (result == STP_ERROR_OUT_OF_MEMORY) {
        return stp_fail_memory(context);
    }
    return result == STP_OK ? STP_OK : stp_fail(context, result, "%s: %s", name, info.reason);
}
