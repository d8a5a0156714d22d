// SPDX-License-Identifier: MIT
// Images, samplers and textures (3.8). A texture of the scene is a picture with its wrap modes, so
// a picture used with two different samplers is copied. Pictures are decoded in jobs.
#include "import/gltf/gltf.h"
#include "import/reading/surface.h"

#include <assert.h>
#include <string.h>

// Pixels decoded together, before the scene takes them and may move them out of memory.
#define PIXELS_OF_BATCH ((uint64_t)1 << 24)
#define PIXEL_BYTES 8u // including the decoder's buffers

enum { WRAP_REPEAT = 10497, WRAP_CLAMP = 33071, WRAP_MIRROR = 33648, FILTER_NEAREST = 9728 };

typedef struct image_state {
    const unsigned char* bytes; ///< NULL: not available, or already decoded
    size_t size;
    unsigned char* owned;
    stp_mapped_file file;
    stp_image_info info;
    stp_result result;
    stp_texture decoded;
    uint32_t first_request; ///< first request for this image; STP_NONE: none
} image_state;

typedef struct texture_request {
    uint32_t image;
    uint32_t next; ///< next request for the same image; STP_NONE: none
    stp_wrap wrap_u, wrap_v;
    bool nearest;
    uint32_t scene_texture;
} texture_request;

struct stp_gltf_textures {
    image_state* images;
    texture_request* requests;
    size_t request_count, request_capacity;
};

stp_result stp_gltf_textures_create(stp_gltf_scope* scope, stp_gltf_textures** textures)
{
    stp_context* context = scope->gltf->context;
    size_t count = stp_gltf_count(scope->gltf, STP_GLTF_IMAGES);
    stp_gltf_textures* made = STP_NEW_ZEROED(context, stp_gltf_textures, 1);
    if (made == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    made->images = STP_NEW_ZEROED(context, image_state, count);
    if (made->images == NULL) {
        stp_free(context, made);
        return STP_ERROR_OUT_OF_MEMORY;
    }
    for (size_t i = 0; i < count; ++i) {
        made->images[i].first_request = STP_NONE;
    }
    *textures = made;
    return STP_OK;
}

static void drop_bytes(image_state* image, stp_context* context)
{
    stp_free(context, image->owned);
    stp_file_unmap(&image->file);
    image->owned = NULL;
    image->bytes = NULL;
}

void stp_gltf_textures_destroy(stp_gltf_textures* textures, stp_gltf* gltf)
{
    if (textures != NULL) {
        for (size_t i = 0; i < stp_gltf_count(gltf, STP_GLTF_IMAGES); ++i) {
            drop_bytes(&textures->images[i], gltf->context);
            stp_free(gltf->context, textures->images[i].decoded.texels);
            stp_free(gltf->context, textures->images[i].decoded.encoded);
        }
        stp_free(gltf->context, textures->requests);
        stp_free(gltf->context, textures->images);
        stp_free(gltf->context, textures);
    }
}

// The image of a texture: from a supported extension, else its own.
static stp_result find_source(stp_gltf_scope* scope, const json_t* json, uint32_t* image)
{
    const json_t* webp;
    stp_result result = stp_gltf_extension(scope, json, "EXT_texture_webp", &webp);
    if (result == STP_OK) {
        result = stp_gltf_index(scope, webp, "source", STP_GLTF_IMAGES, image);
    }
    if (result == STP_OK && *image == STP_NONE) {
        result = stp_gltf_index(scope, json, "source", STP_GLTF_IMAGES, image);
    }
    return result;
}

static stp_wrap to_wrap(size_t code)
{
    return code == WRAP_CLAMP    ? STP_WRAP_CLAMP
           : code == WRAP_MIRROR ? STP_WRAP_MIRROR
                                 : STP_WRAP_REPEAT;
}

static stp_result read_sampler(stp_gltf_scope* scope, const json_t* texture,
                               texture_request* request)
{
    uint32_t sampler = STP_NONE;
    stp_result result = stp_gltf_index(scope, texture, "sampler", STP_GLTF_SAMPLERS, &sampler);
    if (result != STP_OK || sampler == STP_NONE) {
        return result;
    }
    const json_t* json;
    size_t wrap_u = WRAP_REPEAT, wrap_v = WRAP_REPEAT, filter = 0;
    result = stp_gltf_item(scope, STP_GLTF_SAMPLERS, sampler, &json);
    if (result == STP_OK) {
        result = stp_gltf_size(scope, json, "wrapS", &wrap_u);
    }
    if (result == STP_OK) {
        result = stp_gltf_size(scope, json, "wrapT", &wrap_v);
    }
    if (result == STP_OK) {
        result = stp_gltf_size(scope, json, "magFilter", &filter);
    }
    request->wrap_u = to_wrap(wrap_u);
    request->wrap_v = to_wrap(wrap_v);
    request->nearest = filter == FILTER_NEAREST;
    return result;
}

stp_result stp_gltf_textures_want(stp_gltf_scope* scope, stp_gltf_textures* textures,
                                  uint32_t texture, uint32_t* request)
{
    const json_t* json;
    texture_request wanted = {.image = STP_NONE, .next = STP_NONE, .scene_texture = STP_NONE};
    *request = STP_NONE;
    stp_result result = stp_gltf_item(scope, STP_GLTF_TEXTURES, texture, &json);
    if (result == STP_OK) {
        result = find_source(scope, json, &wanted.image);
    }
    if (result == STP_OK) {
        result = read_sampler(scope, json, &wanted);
    }
    if (result != STP_OK) {
        return result;
    }
    if (wanted.image == STP_NONE) {
        stp_gltf_warn(scope, "textures[%u] has no image that can be read and is left out", texture);
        return STP_OK;
    }
    uint32_t* link = &textures->images[wanted.image].first_request;
    while (*link != STP_NONE) { // at most eighteen: three wraps, three wraps, two filters
        texture_request* other = &textures->requests[*link];
        if (other->wrap_u == wanted.wrap_u && other->wrap_v == wanted.wrap_v &&
            other->nearest == wanted.nearest) {
            *request = *link;
            return STP_OK;
        }
        link = &other->next;
    }
    *link = (uint32_t)textures->request_count;
    if (!STP_MAKE_ROOM(scope->gltf->context, textures->requests, textures->request_capacity,
                       textures->request_count + 1)) {
        *link = STP_NONE;
        return STP_ERROR_OUT_OF_MEMORY;
    }
    *request = (uint32_t)textures->request_count;
    assert(textures->request_count < textures->request_capacity);
    textures->requests[textures->request_count++] = wanted;
    return STP_OK;
}

static stp_result open_external(stp_gltf_scope* scope, const char* uri, image_state* image)
{
    const stp_gltf* gltf = scope->gltf;
    char* reference;
    stp_result result = stp_gltf_uri_path(scope, uri, &reference);
    if (result != STP_OK) {
        return result;
    }
    const char* path = NULL;
    result = stp_import_resolve_optional(gltf->import, scope->place, reference, &path);
    stp_free(gltf->context, reference);
    if (result == STP_OK && path != NULL) {
        result = stp_file_map(gltf->context, path, &image->file);
        image->bytes = image->file.bytes;
        image->size = image->file.size;
    }
    return stp_gltf_logged(scope, result);
}

static stp_result open_image(stp_gltf_scope* scope, uint32_t index, image_state* image)
{
    const json_t* json;
    uint32_t view = STP_NONE;
    stp_result result = stp_gltf_item(scope, STP_GLTF_IMAGES, index, &json);
    if (result == STP_OK) {
        result = stp_gltf_index(scope, json, "bufferView", STP_GLTF_BUFFER_VIEWS, &view);
    }
    if (result != STP_OK) {
        return result;
    }
    const char* uri = stp_gltf_text(json, "uri");
    image->decoded.name = stp_gltf_text(json, "name");
    if (view != STP_NONE) {
        size_t stride;
        return stp_gltf_view(scope, view, &image->bytes, &image->size, &stride);
    }
    if (uri == NULL) {
        stp_gltf_warn(scope, "has neither uri nor bufferView and is left out");
        return STP_OK;
    }
    if (stp_gltf_uri_is_data(uri)) {
        result = stp_gltf_uri_decode(scope, uri, &image->owned, &image->size);
        image->bytes = image->owned;
        return result;
    }
    return open_external(scope, uri, image);
}

// Leaves out a picture that cannot be read: a model is of use without it.
static void skip_image(stp_gltf_scope* scope, image_state* image)
{
    stp_gltf_warn(scope, "%s, and is left out", image->info.reason);
    drop_bytes(image, scope->gltf->context);
    image->info.width = image->info.height = 0;
}

// Opens a picture and reads its header. An unsupported or damaged picture is skipped.
static stp_result measure_image(stp_gltf_scope* scope, uint32_t index, image_state* image)
{
    stp_gltf_set_place(scope, "images[%u]", index);
    stp_result result = open_image(scope, index, image);
    if (result != STP_OK || image->bytes == NULL) {
        return result;
    }
    result = stp_image_measure(image->bytes, image->size, &image->info);
    if (result != STP_OK && result != STP_ERROR_OUT_OF_MEMORY) {
        skip_image(scope, image);
        result = STP_OK;
    }
    return result;
}

typedef struct decode_loop {
    stp_context* context;
    stp_gltf_textures* textures;
    size_t first_request;
} decode_loop;

// Whether the picture is decoded for this request.
static bool decodes(const stp_gltf_textures* textures, size_t request)
{
    const image_state* image = &textures->images[textures->requests[request].image];
    return image->first_request == request && image->bytes != NULL;
}

static void decode_job(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    decode_loop* loop = user;
    for (size_t i = begin; i < end; ++i) {
        size_t request = loop->first_request + i;
        if (decodes(loop->textures, request)) {
            image_state* image = &loop->textures->images[loop->textures->requests[request].image];
            image->result = stp_picture_decode_kept(loop->context, image->bytes, image->size,
                                                    &image->info, &image->decoded);
            drop_bytes(image, loop->context);
        }
    }
}

static stp_result measure_images(stp_gltf_scope* scope, stp_gltf_textures* textures, stp_gltf* gltf)
{
    size_t count = stp_gltf_count(gltf, STP_GLTF_IMAGES);
    uint64_t pixels = 0;
    for (size_t i = 0; i < count; ++i) {
        image_state* image = &textures->images[i];
        if (image->first_request == STP_NONE) {
            continue;
        }
        stp_gltf_scope own = stp_gltf_scope_begin(gltf); // so that each picture has its warning
        stp_result result = stp_gltf_scope_end(&own, measure_image(&own, (uint32_t)i, image));
        if (result != STP_OK) {
            return stp_gltf_logged(scope, result);
        }
        gltf->content_bytes += image->file.size;
        for (uint32_t k = image->first_request; k != STP_NONE; k = textures->requests[k].next) {
            pixels += (uint64_t)image->info.width * image->info.height; // each has its own texels
        }
    }
    if (!stp_image_is_plausible(pixels, gltf->content_bytes)) {
        return stp_gltf_fail(scope, STP_ERROR_LIMIT,
                             "the pictures claim %llu pixels in a file of %zu bytes",
                             (unsigned long long)pixels, gltf->content_bytes);
    }
    return STP_OK;
}

// Decodes the pictures of requests [begin, end).
static stp_result decode_images(stp_gltf_scope* scope, stp_gltf_textures* textures, stp_gltf* gltf,
                                size_t begin, size_t end)
{
    assert(begin < end && end <= textures->request_count);
    decode_loop loop = {scope->gltf->context, textures, begin};
    stp_parallel_for(loop.context, end - begin, 1, decode_job, &loop);
    for (size_t i = begin; i < end; ++i) {
        image_state* image = &textures->images[textures->requests[i].image];
        if (image->result == STP_ERROR_OUT_OF_MEMORY) {
            return image->result;
        }
        if (image->result != STP_OK) {
            stp_gltf_scope own = stp_gltf_scope_begin(gltf);
            stp_gltf_set_place(&own, "images[%u]", textures->requests[i].image);
            skip_image(&own, image);
            image->result = stp_gltf_scope_end(&own, STP_OK); // copies of it do not warn again
        }
    }
    return STP_OK;
}

// Gives a texture copies of its texels and encoded bytes. @return false if memory runs out
static bool copy_picture(stp_context* context, stp_texture* texture)
{
    assert(texture->texels != NULL && texture->encoded_size > 0 && "it was decoded");
    size_t size = (size_t)texture->width * texture->height * 4;
    uint8_t* texels = stp_alloc(context, size);
    uint8_t* encoded = stp_alloc(context, texture->encoded_size);
    if (texels == NULL || encoded == NULL) {
        stp_free(context, texels);
        stp_free(context, encoded);
        return false;
    }
    memcpy(texels, texture->texels, size);
    memcpy(encoded, texture->encoded, texture->encoded_size);
    texture->texels = texels;
    texture->encoded = encoded;
    return true;
}

// The last request of a picture takes its texels and bytes; earlier ones get copies.
static stp_result add_texture(stp_gltf_scope* scope, stp_gltf_textures* textures,
                              texture_request* request, stp_gltf* gltf)
{
    image_state* image = &textures->images[request->image];
    stp_texture texture = image->decoded;
    if (texture.width == 0) {
        return STP_OK;
    }
    if (request->next == STP_NONE) {
        image->decoded.texels = image->decoded.encoded = NULL;
    } else if (!copy_picture(gltf->context, &texture)) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    texture.wrap_u = request->wrap_u;
    texture.wrap_v = request->wrap_v;
    texture.nearest = request->nearest;
    return stp_gltf_logged(
        scope, stp_scene_add_texture(gltf->import->scene, &texture, &request->scene_texture));
}

// End of the requests that are decoded together: at least one, until a batch's pixels are reached.
static size_t end_batch(const stp_gltf* gltf, const stp_gltf_textures* textures, size_t begin)
{
    size_t end = begin;
    uint64_t pixels = 0, maximum = stp_gltf_batch(gltf, PIXELS_OF_BATCH, PIXEL_BYTES);
    while (end < textures->request_count && (end == begin || pixels < maximum)) {
        const image_state* image = &textures->images[textures->requests[end].image];
        pixels += decodes(textures, end) ? (uint64_t)image->info.width * image->info.height : 0;
        end += 1;
    }
    assert(end > begin && end <= textures->request_count);
    return end;
}

stp_result stp_gltf_textures_load(stp_gltf_scope* scope, stp_gltf_textures* textures,
                                  stp_gltf* gltf)
{
    stp_result result = measure_images(scope, textures, gltf);
    for (size_t begin = 0; result == STP_OK && begin < textures->request_count;) {
        size_t end = end_batch(gltf, textures, begin);
        result = decode_images(scope, textures, gltf, begin, end);
        for (; result == STP_OK && begin < end; ++begin) {
            result = add_texture(scope, textures, &textures->requests[begin], gltf);
        }
    }
    return result;
}

uint32_t stp_gltf_textures_get(const stp_gltf_textures* textures, uint32_t request)
{
    assert(request == STP_NONE || request < textures->request_count);
    return request == STP_NONE ? STP_NONE : textures->requests[request].scene_texture;
}
