// SPDX-License-Identifier: MIT
#include "gltf_writer.h"

#include <spng.h>
#include <stdio.h>
#include <webp/encode.h>

// Two by two texels: red, green, blue, white.
static const uint8_t texels[16] = {255, 0, 0,   255, 0,   255, 0,   255,
                                   0,   0, 255, 255, 255, 255, 255, 255};

static void* encode_png(size_t* size)
{
    spng_ctx* png = spng_ctx_new(SPNG_CTX_ENCODER);
    struct spng_ihdr header = {
        .width = 2, .height = 2, .bit_depth = 8, .color_type = SPNG_COLOR_TYPE_TRUECOLOR_ALPHA};
    spng_set_option(png, SPNG_ENCODE_TO_BUFFER, 1);
    spng_set_ihdr(png, &header);
    spng_encode_image(png, texels, sizeof(texels), SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE);
    int error = 0;
    void* bytes = spng_get_png_buffer(png, size, &error);
    spng_ctx_free(png);
    return bytes;
}

// Imports materials over one picture in the binary chunk.
static void run_materials(gltf_run* run, const char* json, const void* picture, size_t size)
{
    char text[4096];
    snprintf(text, sizeof(text),
             "{" GLTF_ASSET ",'buffers':[{'byteLength':%zu}],"
             "'bufferViews':[{'buffer':0,'byteLength':%zu}],%s}",
             size, size, json);
    gltf_run_glb(run, text, picture, size);
}

void test_gltf_reads_material_factors(test_state* test)
{
    gltf_run run;
    gltf_run_glb(
        &run,
        "{" GLTF_ASSET ",'materials':[{'name':'steel','doubleSided':true,'alphaMode':'MASK',"
        "'alphaCutoff':0.25,'emissiveFactor':[0.5,0,1],'pbrMetallicRoughness':"
        "{'baseColorFactor':[0.1,0.2,0.3,0.4],'metallicFactor':0.5,'roughnessFactor':0.75},"
        "'extensions':{'KHR_materials_emissive_strength':{'emissiveStrength':4},"
        "'KHR_materials_unlit':{}}},{'alphaMode':'BLEND'},"
        "{'extensions':{'KHR_materials_pbrSpecularGlossiness':{'diffuseFactor':[1,0,0,1],"
        "'glossinessFactor':0.25}}}]}",
        NULL, 0);
    CHECK_EQUAL(STP_OK, run.result);
    CHECK_EQUAL(4, run.scene->material_count); // the default comes first
    const stp_material* m = &run.scene->materials[1];
    CHECK(strcmp(m->name, "steel") == 0 && m->double_sided && m->unlit);
    CHECK(m->alpha_mode == STP_ALPHA_MASK && m->alpha_cutoff == 0.25f);
    CHECK(m->base_color[0] == 0.1f && m->base_color[3] == 0.4f);
    CHECK(m->metallic == 0.5f && m->roughness == 0.75f);
    CHECK(m->emissive[0] == 2.0f && m->emissive[2] == 4.0f);
    CHECK_EQUAL(STP_NONE, m->base_color_texture.texture);
    CHECK(m[1].alpha_mode == STP_ALPHA_BLEND && m[1].metallic == 1.0f && !m[1].unlit);
    CHECK(m[2].base_color[1] == 0.0f && m[2].metallic == 0.0f && m[2].roughness == 0.75f);
    CHECK(!run.scene->materials[0].front_only && !m->front_only && m[1].front_only);
    gltf_run_end(&run);
}

// Single-sided unless it says otherwise; points have no sides.
void test_gltf_materials_have_sides(test_state* test)
{
    // a closed tetrahedron, its fronts outwards; then inwards
    static const float corners[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const uint16_t indices[2][12] = {{0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3},
                                            {0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2}};
    unsigned char bin[sizeof(corners) + sizeof(indices)];
    memcpy(bin, corners, sizeof(corners));
    memcpy(bin + sizeof(corners), indices, sizeof(indices));
    gltf_run run;
    gltf_run_glb(&run,
                 "{" GLTF_ASSET ",'buffers':[{'byteLength':96}],'bufferViews':["
                 "{'buffer':0,'byteLength':48},{'buffer':0,'byteOffset':48,'byteLength':24},"
                 "{'buffer':0,'byteOffset':72,'byteLength':24}],'accessors':["
                 "{'bufferView':0,'componentType':5126,'count':4,'type':'VEC3','min':[0,0,0],"
                 "'max':[1,1,1]},{'bufferView':1,'componentType':5123,'count':12,'type':'SCALAR'},"
                 "{'bufferView':2,'componentType':5123,'count':12,'type':'SCALAR'}],'materials':["
                 "{'name':'sheet'},{'doubleSided':true,'name':'both'},{'name':'dots'}],'meshes':["
                 "{'name':'skin','primitives':["
                 "{'attributes':{'POSITION':0},'indices':1,'material':0},"
                 "{'attributes':{'POSITION':0},'indices':2,'material':1},"
                 "{'attributes':{'POSITION':0},'mode':0,'material':2},"
                 "{'attributes':{'POSITION':0},'mode':1,'material':0}," // edges are not read
                 "{'attributes':{'POSITION':0},'indices':2}]}],"
                 "'nodes':[{'mesh':0}],'scenes':[{'nodes':[0]}],'scene':0}",
                 bin, sizeof(bin));
    CHECK_EQUAL(STP_OK, run.result);
    CHECK_EQUAL(5, run.scene->material_count); // and that of triangles without one
    const stp_material* m = run.scene->materials;
    CHECK(!m[0].front_only && m[1].front_only && !m[2].front_only && !m[3].front_only);
    CHECK(m[4].front_only && !m[4].double_sided);
    CHECK_EQUAL(STP_OK, stp_scene_finish(run.scene));
    uint32_t inverted = 0;
    for (size_t i = 0; i < run.scene->material_count; ++i) {
        inverted += run.scene->materials[i].inverted;
    }
    CHECK_EQUAL(1, inverted); // two-sided ones do not count
    CHECK(strstr(run.log.warning, "face inwards, and only their inside is drawn: 1") != NULL);
    gltf_run_end(&run);
}

void test_gltf_transforms_textures(test_state* test)
{
    size_t size = 0;
    void* png = encode_png(&size);
    gltf_run run;
    // the extension's own example: the lower left quadrant, rotated
    run_materials(&run,
                  "'extensionsRequired':['KHR_texture_transform'],'images':[{'bufferView':0}],"
                  "'textures':[{'source':0}],'materials':[{'pbrMetallicRoughness':"
                  "{'baseColorTexture':{'index':0,'extensions':{'KHR_texture_transform':"
                  "{'offset':[0,1],'rotation':1.57079632679,'scale':[0.5,0.5]}}},"
                  "'metallicRoughnessTexture':{'index':0,'extensions':{'KHR_texture_transform':"
                  "{'rotation':-3.14159265359,'scale':[2,3],'offset':[0.25,0]}}}}}]",
                  png, size);
    CHECK_EQUAL(STP_OK, run.result);
    const stp_texture_use* use = &run.scene->materials[1].base_color_texture;
    CHECK_EQUAL(0, use->texture);
    for (int corner = 0; corner < 4; ++corner) {
        double u = corner & 1, v = corner >> 1;
        double x = (double)use->transform[0][0] * u + (double)use->transform[0][1] * v +
                   (double)use->transform[0][2];
        double y = (double)use->transform[1][0] * u + (double)use->transform[1][1] * v +
                   (double)use->transform[1][2];
        CHECK(gltf_near(x, 0.5 * v) && gltf_near(y, 1.0 - 0.5 * u));
    }
    use = &run.scene->materials[1].metallic_roughness_texture;
    CHECK(gltf_near((double)use->transform[0][0], -2.0));
    CHECK(gltf_near((double)use->transform[1][1], -3.0));
    CHECK(gltf_near((double)use->transform[0][1], 0.0) && use->transform[0][2] == 0.25f);
    gltf_run_end(&run);
    free(png);
}

void test_gltf_textures_are_pictures_with_samplers(test_state* test)
{
    size_t size = 0;
    void* png = encode_png(&size);
    gltf_run run;
    run_materials(&run,
                  "'images':[{'bufferView':0,'mimeType':'image/png','name':'tiles'}],"
                  "'samplers':[{'wrapS':33071,'wrapT':33648,'magFilter':9728},{}],"
                  "'textures':[{'source':0},{'source':0,'sampler':0},{'source':0,'sampler':1}],"
                  "'materials':[{'pbrMetallicRoughness':{'baseColorTexture':{'index':0},"
                  "'metallicRoughnessTexture':{'index':1}},'emissiveTexture':{'index':2}}]",
                  png, size);
    CHECK_EQUAL(STP_OK, run.result);
    CHECK_EQUAL(2, run.scene->texture_count); // textures 0 and 2 are equal
    for (uint32_t i = 0; i < 2; ++i) {        // as they came
        const stp_texture* texture = &run.scene->textures[i];
        CHECK_EQUAL(STP_TEXTURE_PNG, texture->encoding);
        CHECK(texture->encoded_size == size && memcmp(texture->encoded, png, size) == 0);
    }
    const stp_material* m = &run.scene->materials[1];
    CHECK_EQUAL(m->base_color_texture.texture, m->emissive_texture.texture);
    const stp_texture* plain = &run.scene->textures[m->base_color_texture.texture];
    const stp_texture* other = &run.scene->textures[m->metallic_roughness_texture.texture];
    CHECK(plain->wrap_u == STP_WRAP_REPEAT && !plain->nearest);
    CHECK(other->wrap_u == STP_WRAP_CLAMP && other->wrap_v == STP_WRAP_MIRROR && other->nearest);
    CHECK(memcmp(plain->texels, texels, 16) == 0 && memcmp(other->texels, texels, 16) == 0);
    CHECK(strcmp(plain->name, "tiles") == 0);
    gltf_run_end(&run);
    free(png);
}

void test_gltf_reads_webp_textures(test_state* test)
{
    uint8_t* webp = NULL;
    size_t size = WebPEncodeLosslessRGBA(texels, 2, 2, 8, &webp);
    gltf_run run;
    run_materials(&run,
                  "'extensionsRequired':['EXT_texture_webp'],'images':[{'bufferView':0}],"
                  "'textures':[{'extensions':{'EXT_texture_webp':{'source':0}}}],"
                  "'materials':[{'emissiveTexture':{'index':0}}]",
                  webp, size);
    CHECK_EQUAL(STP_OK, run.result);
    CHECK_EQUAL(1, run.scene->texture_count);
    CHECK(memcmp(run.scene->textures[0].texels, texels, 16) == 0);
    gltf_run_end(&run);
    WebPFree(webp);
}

void test_gltf_survives_missing_pictures(test_state* test)
{
    const unsigned char ktx2[12] = {0xAB, 'K', 'T', 'X', ' ', '2', '0', 0xBB, 13, 10, 26, 10};
    const char* images[] = {"{'bufferView':0}", "{'uri':'no/such/file.png'}",
                            "{'uri':'http://example.com/a.png'}", "{}",
                            "{'uri':'data:text/plain,hello'}"};
    for (size_t i = 0; i < sizeof(images) / sizeof(images[0]); ++i) {
        char json[1024];
        snprintf(json, sizeof(json),
                 "'images':[%s],'textures':[{'source':0},{}],'materials':[{"
                 "'emissiveTexture':{'index':0},"
                 "'pbrMetallicRoughness':{'baseColorTexture':{'index':1}}}]",
                 images[i]);
        gltf_run run;
        run_materials(&run, json, ktx2, sizeof(ktx2));
        CHECK_EQUAL(STP_OK, run.result);
        CHECK_EQUAL(0, run.log.errors);
        CHECK_EQUAL(0, run.scene->texture_count);
        CHECK_EQUAL(STP_NONE, run.scene->materials[1].emissive_texture.texture);
        gltf_run_end(&run);
    }
}

void test_gltf_leaves_out_damaged_pictures(test_state* test)
{
    size_t size = 0;
    unsigned char* png = encode_png(&size);
    png[45] ^= 0x55;
    gltf_run run;
    run_materials(&run,
                  "'images':[{'bufferView':0}],'textures':[{'source':0},{'source':0,'sampler':0}],"
                  "'samplers':[{'wrapS':33071}],'materials':[{'emissiveTexture':{'index':0},"
                  "'pbrMetallicRoughness':{'baseColorTexture':{'index':1}}}]",
                  png, size);
    CHECK_EQUAL(STP_OK, run.result);
    CHECK_EQUAL(1, run.log.warnings);
    CHECK(strstr(run.log.warning, "test.glb: images[0]: PNG picture: ") == run.log.warning);
    CHECK_EQUAL(0, run.scene->texture_count);
    CHECK_EQUAL(STP_NONE, run.scene->materials[1].emissive_texture.texture);
    gltf_run_end(&run);
    run_materials(&run,
                  "'images':[{'bufferView':0}],'textures':[{'source':0}],"
                  "'materials':[{'emissiveTexture':{'index':0}}]",
                  png, 40); // ends in its header
    CHECK_EQUAL(STP_OK, run.result);
    CHECK_EQUAL(1, run.log.warnings);
    gltf_run_end(&run);
    free(png);
}

void test_gltf_reads_normal_maps(test_state* test)
{
    size_t size = 0;
    void* png = encode_png(&size);
    const char* maps[] = {"'normalTexture':{'index':0}",
                          "'normalTexture':{'index':0,'scale':-0.5,'texCoord':1,'extensions':{"
                          "'KHR_texture_transform':{'scale':[2,3]}}}",
                          "'normalTexture':{'index':0,'scale':0}",
                          "'normalTexture':{'index':0,'scale':1e9}",
                          "'extensions':{'KHR_materials_unlit':{}},'normalTexture':{'index':0}",
                          "'emissiveTexture':{'index':0,'texCoord':1},'pbrMetallicRoughness':{"
                          "'baseColorTexture':{'index':0}},"
                          "'normalTexture':{'index':0,'texCoord':2}"};
    for (int i = 0; i < 6; ++i) {
        char json[1024];
        snprintf(json, sizeof(json),
                 "'images':[{'bufferView':0}],'textures':[{'source':0}],'materials':[{%s}]",
                 maps[i]);
        gltf_run run;
        run_materials(&run, json, png, size);
        CHECK_EQUAL(STP_OK, run.result);
        const stp_material* m = &run.scene->materials[1];
        CHECK((m->normal_texture.texture != STP_NONE) == (i < 2 || i == 3));
        CHECK(m->normal_texture.texture == STP_NONE || m->normal_scale == (i == 1 ? -0.5f : 1.0f));
        CHECK(i != 1 || m->normal_texture.transform[1][1] == 3.0f);
        CHECK_EQUAL(i == 2 || i == 4 ? 0 : 1, run.scene->texture_count); // else it is not read
        CHECK_EQUAL(i == 3 || i == 5 ? 1 : 0, run.log.warnings);
        CHECK_EQUAL(0, run.log.errors);
        gltf_run_end(&run);
    }
    ((unsigned char*)png)[45] ^= 0x55;
    gltf_run run;
    run_materials(&run,
                  "'images':[{'bufferView':0}],'textures':[{'source':0}],"
                  "'materials':[{'normalTexture':{'index':0}}]",
                  png, size);
    CHECK_EQUAL(STP_OK, run.result); // the model stays
    CHECK_EQUAL(1, run.log.warnings);
    CHECK_EQUAL(STP_NONE, run.scene->materials[1].normal_texture.texture);
    gltf_run_end(&run);
    free(png);
}

void test_gltf_maps_texture_coordinates_to_two_sets(test_state* test)
{
    struct {
        float positions[9], first[6], third[6];
        unsigned char png[200];
    } data = {.positions = {0, 0, 0, 1, 0, 0, 0, 1, 0},
              .first = {1, 2, 3, 4, 5, 6},
              .third = {7, 8, 9, 10, 11, 12}};
    size_t size = 0;
    void* png = encode_png(&size);
    CHECK(size <= sizeof(data.png));
    memcpy(data.png, png, size);
    free(png);
    char json[2048];
    snprintf(json, sizeof(json),
             "{" GLTF_ASSET ",'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0}],"
             "'buffers':[{'byteLength':284}],'bufferViews':[{'buffer':0,'byteLength':84},"
             "{'buffer':0,'byteOffset':84,'byteLength':%zu}],'accessors':["
             "{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'},"
             "{'bufferView':0,'byteOffset':36,'componentType':5126,'count':3,'type':'VEC2'},"
             "{'bufferView':0,'byteOffset':60,'componentType':5126,'count':3,'type':'VEC2'}],"
             "'meshes':[{'primitives':[{'material':0,'attributes':{'POSITION':0,'TEXCOORD_0':1,"
             "'TEXCOORD_1':1,'TEXCOORD_2':2}}]}],'images':[{'bufferView':1}],"
             "'textures':[{'source':0}],'materials':[{'pbrMetallicRoughness':{"
             "'baseColorTexture':{'index':0,'texCoord':2}},"
             "'emissiveTexture':{'index':0,'texCoord':0}}]}",
             size);
    gltf_run run;
    gltf_run_glb(&run, json, &data, sizeof(data));
    CHECK_EQUAL(STP_OK, run.result);
    const stp_material* m = &run.scene->materials[1];
    const stp_mesh* mesh = &run.scene->meshes[0];
    CHECK_EQUAL(1, mesh->material);
    CHECK(mesh->texcoords[m->base_color_texture.texcoord][0] == 7.0f);
    CHECK(mesh->texcoords[m->emissive_texture.texcoord][0] == 1.0f);
    gltf_run_end(&run);
}
