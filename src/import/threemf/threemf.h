// SPDX-License-Identifier: MIT
//
// Inside the 3MF reader: the archive (zip.h), its root model (threemf_package.c), the XML of models
// (threemf_model.c), and the scene (format_3mf.c).
//
// Facts of the format: 3MF Core Specification 1.3, Materials 1.2, Production 1.1.
#pragma once

#include "import/reading/lookup.h"
#include "import/threemf/zip.h"

/// Colours or texture coordinates that triangles name by a group and an index.
typedef struct stp_3mf_group {
    uint32_t texture;    ///< of texture coordinates; STP_NONE: colours
    size_t first, count; ///< its values
} stp_3mf_group;

/// A picture of the archive.
typedef struct stp_3mf_texture {
    const char* path;
    stp_wrap wrap_u, wrap_v;
    uint32_t material; ///< made on first use; STP_NONE: none yet
    size_t builder;    ///< of its mesh of the object being added; SIZE_MAX: none
} stp_3mf_texture;

typedef struct stp_3mf_triangle {
    uint32_t corners[3];
    uint32_t group;     ///< STP_NONE: none
    uint32_t values[3]; ///< within the group
} stp_3mf_triangle;

/// Another object's content, in an object or in the build.
typedef struct stp_3mf_use {
    const char* path; ///< of the model with the object; NULL: the same one
    uint32_t model, id;
    const char* name; ///< may be NULL
    stp_affine transform;
} stp_3mf_use;

typedef struct stp_3mf_object {
    uint32_t model;
    const char* name;      ///< may be NULL
    uint32_t group, value; ///< of triangles without their own
    size_t first_vertex, vertex_count, first_triangle, triangle_count, first_use, use_count;
    bool open;      ///< its uses are being added to the scene
    uint32_t added; ///< its object in the scene; STP_NONE: none yet
} stp_3mf_object;

typedef struct stp_3mf {
    stp_import* import;
    stp_context* context;
    stp_zip zip;
    double unit_metres;
    const char** models; ///< paths of model files that were asked for
    uint32_t root;       ///< the model with the build; STP_NONE: the first that has items
    size_t model_count, model_capacity, parsed;
    stp_3mf_object* objects;
    stp_3mf_group* groups;
    stp_3mf_texture* textures;
    stp_3mf_triangle* triangles;
    stp_3mf_use *uses, *items; ///< of objects, and of the build
    float (*values)[4];        ///< colours (sRGB, with alpha), or texture coordinates
    float (*vertices)[3];
    size_t object_count, group_count, texture_count, triangle_count, use_count, item_count,
        value_count, vertex_count;
    size_t object_capacity, group_capacity, texture_capacity, triangle_capacity, use_capacity,
        item_capacity, value_capacity, vertex_capacity;
    stp_lookup names;    ///< by kind, model and id: objects, groups, textures
    stp_lookup paths;    ///< models by path
    stp_lookup pictures; ///< textures by path and wrap
} stp_3mf;

typedef enum stp_3mf_kind { STP_3MF_OBJECT, STP_3MF_GROUP, STP_3MF_TEXTURE } stp_3mf_kind;

/// The index of what has an id in a model; STP_NONE: nothing.
uint32_t stp_3mf_find(const stp_3mf* m, stp_3mf_kind kind, uint32_t model, uint32_t id);
/// The number of a model's path; adds it to the models if it is new. @return STP_OK,
/// STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_3mf_find_model(stp_3mf* m, const char* path, uint32_t* model);
/// Finds the root model, or all models if it is not known. @return STP_OK, STP_ERROR_FORMAT,
/// STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_3mf_find_root(stp_3mf* m);
/// Parses model `model` and adds its content. @return STP_OK, or a failure, logged
STP_MUST_USE stp_result stp_3mf_parse(stp_3mf* m, uint32_t model);
