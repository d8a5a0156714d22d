// SPDX-License-Identifier: MIT
// Picks of single-sided surfaces follow the picture: with back faces, or without.
#include "support_embed.h"

#include <stdio.h>
#include <unistd.h>

/// A triangle in the plane z = 0 that faces +z, single-sided as glTF materials are.
static const char sheet[] =
    "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":36,\"uri\":"
    "\"data:application/octet-stream;base64,"
    "AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA\"}],"
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"accessors\":[{\"bufferView\":0,"
    "\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[-1,-1,0],\"max\":[1,1,0]}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"nodes\":[{\"mesh\":0}],"
    "\"scenes\":[{\"nodes\":[0]}],\"scene\":0}";

static bool write_sheet(const char* path)
{
    FILE* file = fopen(path, "wb");
    bool written = file != NULL && fputs(sheet, file) >= 0;
    return file != NULL && fclose(file) == 0 && written;
}

/// Whether the middle of a view from z hits anything.
static bool is_hit(stp_model* model, double z, const stp_hit_desc* desc)
{
    stp_view view = embed_view();
    stp_hit hit = {0};
    view.eye = (stp_vec3d){0, 0, z};
    view.target = (stp_vec3d){0, 0, 0};
    double middle = EMBED_SIDE / 2.0;
    return stp_model_pick_with(model, &view, desc, middle, middle, &hit) == STP_OK && hit.hit;
}

void test_embed_picks_follow_back_faces(test_state* test)
{
    char path[64];
    snprintf(path, sizeof(path), "stp_embed_sides_%d.gltf", (int)getpid());
    stp_context* context = test_context(NULL, 1, NULL);
    stp_builder* builder = NULL;
    stp_model* model = NULL;
    size_t size = 0;
    CHECK(context != NULL && write_sheet(path));
    stp_result result = stp_builder_create(context, NULL, &builder);
    result = result == STP_OK ? stp_builder_add_file(builder, path) : result;
    result = result == STP_OK ? stp_builder_write(builder, &(stp_write_desc){0}, NULL) : result;
    unlink(path);
    CHECK_EQUAL(STP_OK, result);
    const void* bytes = stp_builder_get_bytes(builder, &size);
    CHECK_EQUAL(STP_OK,
                stp_model_open(context, &(stp_model_desc){.bytes = bytes, .size = size}, &model));
    const stp_hit_desc all = {.struct_size = sizeof(all), .back_faces = true}, plain = {0};
    CHECK(is_hit(model, 5.0, NULL) && is_hit(model, 5.0, &plain) && is_hit(model, 5.0, &all));
    CHECK(!is_hit(model, -5.0, NULL) && !is_hit(model, -5.0, &plain));
    CHECK(is_hit(model, -5.0, &all));
    stp_model_close(model);
    stp_builder_destroy(builder);
    stp_context_destroy(context);
}
