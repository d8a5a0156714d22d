// SPDX-License-Identifier: MIT
#include "gltf_writer.h"

#include <stdio.h>

// One triangle, for tests that need a mesh.
#define TRIANGLE                                                                                   \
    "'buffers':[{'byteLength':36}],'bufferViews':[{'buffer':0,'byteLength':36}],"                  \
    "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}],"                 \
    "'meshes':[{'name':'triangle','primitives':[{'attributes':{'POSITION':0}}]}]"

static const float triangle[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};

static stp_vec3d to_world(const stp_scene* scene, uint32_t object, stp_vec3d p)
{
    while (object != STP_NONE) {
        p = stp_affine_point(&scene->objects[object].transform, p);
        object = scene->objects[object].parent;
    }
    return p;
}

void test_gltf_keeps_hierarchy_names_and_ids(test_state* test)
{
    gltf_run run;
    gltf_run_glb(&run,
                 "{" GLTF_ASSET ",'scene':0,'scenes':[{'nodes':[2]}],'nodes':["
                 "{'mesh':0,'name':'bolt','extras':{'guid':'3x','n':[1,2]}},"
                 "{'mesh':0,'translation':[0,0,5]},"
                 "{'children':[1,0],'name':'plant','rotation':[0,0.7071067811865476,0,"
                 "0.7071067811865476],'scale':[2,2,2],'translation':[10,0,0]},"
                 "{'mesh':0,'name':'outside the scene'}]," TRIANGLE "}",
                 triangle, sizeof(triangle));
    CHECK_EQUAL(STP_OK, run.result);
    const stp_scene* scene = run.scene;
    CHECK_EQUAL(4, scene->object_count); // the file, plant, nodes 1 and 0
    CHECK_EQUAL(1, scene->mesh_count);   // shared
    CHECK(strcmp(scene->objects[0].name, "test.glb") == 0 && scene->objects[0].part_count == 0);
    CHECK(strcmp(scene->objects[1].name, "plant") == 0 && scene->objects[1].parent == 0);
    CHECK(strcmp(scene->objects[2].name, "triangle") == 0 && scene->objects[2].parent == 1);
    CHECK(strcmp(scene->objects[3].name, "bolt") == 0 && scene->objects[3].parent == 1);
    CHECK(strcmp(scene->objects[3].id, "{\"guid\":\"3x\",\"n\":[1,2]}") == 0);
    CHECK(scene->objects[2].id == NULL);
    // a quarter turn about y takes +z to +x, after the scale
    stp_vec3d p = to_world(scene, 2, (stp_vec3d){0, 1, 0});
    CHECK(gltf_near(p.x, 20.0) && gltf_near(p.y, 2.0) && gltf_near(p.z, 0.0));
    CHECK(scene->unit_metres == 1.0 && strcmp(scene->up, "y") == 0);
    CHECK_EQUAL(1, scene->source_count);
    CHECK(strcmp(scene->sources[0].format, "gltf") == 0);
    gltf_run_end(&run);
}

void test_gltf_reads_matrices_by_columns(test_state* test)
{
    gltf_run run;
    gltf_run_glb(&run,
                 "{" GLTF_ASSET ",'scenes':[{'nodes':[0]}],'nodes':["
                 "{'mesh':0,'matrix':[0,1,0,0, -1,0,0,0, 0,0,1,0, 7,8,9,1]}]," TRIANGLE "}",
                 triangle, sizeof(triangle));
    CHECK_EQUAL(STP_OK, run.result);
    stp_vec3d p = to_world(run.scene, 1, (stp_vec3d){1, 0, 0});
    CHECK(p.x == 7.0 && p.y == 9.0 && p.z == 9.0);
    gltf_run_end(&run);
}

void test_gltf_refuses_graphs_that_are_no_trees(test_state* test)
{
    const struct {
        const char *nodes, *message;
    } cases[] = {
        {"{'children':[1]},{'children':[0]}",
         "test.glb: nodes[0] is its own ancestor, or below one that is"},
        {"{},{'children':[1]}", "test.glb: nodes[1] is its own ancestor, or below one that is"},
        {"{'children':[2]},{'children':[2]},{}",
         "test.glb: nodes[1]: its child nodes[2] already has a parent, nodes[0]"},
        {"{'children':[1,1]},{}",
         "test.glb: nodes[0]: its child nodes[1] already has a parent, nodes[0]"},
        {"{'children':[7]}", "test.glb: nodes[0]: element 0 is not an index below 1"},
        {"{'children':[-1]}", "test.glb: nodes[0]: element 0 is not an index below 1"},
        {"{},{'children':[0]}", "test.glb: scenes[0].nodes: nodes[0] is not a root but a child of "
                                "nodes[1]"},
        {"{'scale':[1e300,1,1],'children':[1]},{'scale':[1e300,1,1]}",
         "test.glb: nodes[1]: the transform to the world is not finite"},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        char json[1024];
        snprintf(json, sizeof(json), "{" GLTF_ASSET ",'scenes':[{'nodes':[0]}],'nodes':[%s]}",
                 cases[i].nodes);
        gltf_run run;
        gltf_run_glb(&run, json, NULL, 0);
        CHECK_EQUAL(STP_ERROR_FORMAT, run.result);
        CHECK_EQUAL(1, run.log.errors);
        CHECK(strcmp(run.log.text, cases[i].message) == 0);
        gltf_run_end(&run);
    }
}

void test_gltf_reads_deep_hierarchies(test_state* test)
{
    size_t depth = 100000, at = 0;
    char* json = malloc(depth * 48 + 256);
    CHECK(json != NULL);
    at += (size_t)sprintf(json, "{" GLTF_ASSET ",'scenes':[{'nodes':[0]}],'nodes':[");
    for (size_t i = 0; i + 1 < depth; ++i) {
        at += (size_t)sprintf(json + at, "{'children':[%zu]},", i + 1);
    }
    sprintf(json + at, "{'name':'last'}]}");
    gltf_run run;
    gltf_run_text(&run, json);
    free(json);
    CHECK_EQUAL(STP_OK, run.result);
    CHECK_EQUAL(depth + 1, run.scene->object_count);
    CHECK_EQUAL(depth - 1, run.scene->objects[depth].parent);
    CHECK(strcmp(run.scene->objects[depth].name, "last") == 0);
    gltf_run_end(&run);
}

void test_gltf_cameras_become_views(test_state* test)
{
    gltf_run run;
    gltf_run_glb(
        &run,
        "{" GLTF_ASSET ",'scenes':[{'nodes':[0]}],'nodes':["
        "{'children':[1,2,3,4],'translation':[0,10,0],'scale':[3,3,3]},"
        "{'camera':0,'name':'door','rotation':[0,0.7071067811865476,0,0.7071067811865476]},"
        "{'camera':1,'translation':[1,0,0]},{'camera':2},{'camera':3}],"
        "'cameras':[{'type':'perspective','perspective':{'yfov':1.5707963267948966,'znear':1}},"
        "{'type':'perspective','perspective':{'yfov':1,'znear':1}},"
        "{'type':'orthographic','orthographic':{'xmag':1,'ymag':1,'zfar':9,'znear':0}},"
        "{'type':'perspective','perspective':{'yfov':1e-9,'znear':1}}]}",
        NULL, 0);
    CHECK_EQUAL(STP_OK, run.result);
    CHECK_EQUAL(2, run.scene->view_count);
    const stp_scene_view* view = &run.scene->views[0];
    CHECK(strcmp(view->name, "door") == 0 && gltf_near(view->fov_degrees, 90.0));
    CHECK(gltf_near(view->eye.y, 10.0) && gltf_near(view->target.x - view->eye.x, -1.0));
    CHECK(gltf_near(view->up.y, 1.0));
    CHECK(strcmp(run.scene->views[1].name, "camera1") == 0);
    CHECK(gltf_near(run.scene->views[1].eye.x, 3.0));
    CHECK(gltf_near(run.scene->views[1].target.z, -1.0));
    gltf_run_end(&run);
}

void test_gltf_reads_gpu_instancing(test_state* test)
{
    const struct {
        float positions[9], translations[6], scales[6];
        int16_t rotations[8];
    } data = {{0, 0, 0, 1, 0, 0, 0, 1, 0},
              {1, 2, 3, 4, 5, 6},
              {1, 1, 1, 2, 2, 2},
              {0, 0, 0, 32767, 0, 32767, 0, 0}}; // none, and half a turn about y
    const char* form = "{" GLTF_ASSET ",'extensionsRequired':['EXT_mesh_gpu_instancing'],"
                       "'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0,'extensions':{"
                       "'EXT_mesh_gpu_instancing':{'attributes':{'TRANSLATION':1,'ROTATION':2,"
                       "'SCALE':3}}}}],'buffers':[{'byteLength':100}],"
                       "'bufferViews':[{'buffer':0,'byteLength':100}],'accessors':["
                       "{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'},"
                       "{'bufferView':0,'byteOffset':36,'componentType':5126,'count':2,"
                       "'type':'VEC3'},{'bufferView':0,'byteOffset':84,'componentType':5122,"
                       "'normalized':true,'count':%d,'type':'VEC4'},{'bufferView':0,"
                       "'byteOffset':60,'componentType':5126,'count':2,'type':'VEC3'}],"
                       "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]}";
    for (int rotations = 1; rotations <= 2; ++rotations) {
        char json[2048];
        snprintf(json, sizeof(json), form, rotations);
        gltf_run run;
        gltf_run_glb(&run, json, &data, sizeof(data));
        if (rotations == 1) { // not as many as translations
            CHECK_EQUAL(STP_ERROR_FORMAT, run.result);
        } else {
            CHECK_EQUAL(STP_OK, run.result);
            CHECK_EQUAL(2, run.scene->objects[1].instance_count);
            stp_vec3d p = stp_affine_point(&run.scene->instances[0], (stp_vec3d){1, 1, 1});
            CHECK(p.x == 2.0 && p.y == 3.0 && p.z == 4.0);
            p = stp_affine_point(&run.scene->instances[1], (stp_vec3d){1, 1, 1});
            CHECK(gltf_near(p.x, 2.0) && gltf_near(p.y, 7.0) && gltf_near(p.z, 4.0));
        }
        gltf_run_end(&run);
    }
}

void test_gltf_flags_what_animations_move(test_state* test)
{
    gltf_run run;
    gltf_run_glb(&run,
                 "{" GLTF_ASSET ",'scenes':[{'nodes':[0,1]}],'nodes':[{'mesh':0},{'mesh':0}],"
                 "'animations':[{'samplers':[{'input':0,'output':0}],'channels':[{'sampler':0,"
                 "'target':{'node':1,'path':'translation'}}]}]," TRIANGLE "}",
                 triangle, sizeof(triangle));
    CHECK_EQUAL(STP_OK, run.result);
    CHECK_EQUAL(0, run.scene->objects[1].flags);
    CHECK_EQUAL(STP_OBJECT_MOVING, run.scene->objects[2].flags);
    gltf_run_end(&run);
}

// Two joints: one moved up by its node, one with an inverse bind matrix that moves right.
void test_gltf_skins_stand_at_rest(test_state* test)
{
    struct {
        float positions[9], weights[12], binds[32];
        uint8_t joints[12];
    } data = {.positions = {0, 0, 0, 1, 0, 0, 0, 1, 0},
              .weights = {1, 0, 0, 0, 0, 1, 0, 0, 1, 1, 0, 0},
              .joints = {0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0}};
    for (int m = 0; m < 2; ++m) {
        for (int d = 0; d < 4; ++d) {
            data.binds[16 * m + 5 * d] = 1.0f;
        }
    }
    data.binds[16 + 12] = 4.0f; // the second joint's translation along x
    gltf_run run;
    gltf_run_glb(
        &run,
        "{" GLTF_ASSET ",'scenes':[{'nodes':[0,3]}],'nodes':[{'children':[1,2]},"
        "{'translation':[0,5,0]},{},"
        "{'mesh':0,'skin':0,'name':'body','translation':[100,100,100]}],"
        "'skins':[{'joints':[1,2],'inverseBindMatrices':3}],"
        "'buffers':[{'byteLength':224}],'bufferViews':[{'buffer':0,'byteLength':224}],"
        "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'},"
        "{'bufferView':0,'byteOffset':212,'componentType':5121,'count':3,'type':'VEC4'},"
        "{'bufferView':0,'byteOffset':36,'componentType':5126,'count':3,'type':'VEC4'},"
        "{'bufferView':0,'byteOffset':84,'componentType':5126,'count':2,'type':'MAT4'}],"
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'JOINTS_0':1,'WEIGHTS_0':2}}]}]}",
        &data, sizeof(data));
    CHECK_EQUAL(STP_OK, run.result);
    const stp_scene* scene = run.scene;
    uint32_t body = (uint32_t)scene->object_count - 1;
    CHECK_EQUAL(1, scene->objects[body].part_count);
    CHECK_EQUAL(STP_OBJECT_MOVING, scene->objects[body].flags);
    const double expected[3][3] = {{0, 5, 0}, {5, 0, 0}, {2, 3.5, 0}};
    for (int v = 0; v < 3; ++v) {
        const float* p = scene->meshes[0].positions + 3 * v;
        stp_vec3d world =
            to_world(scene, body, (stp_vec3d){(double)p[0], (double)p[1], (double)p[2]});
        CHECK(gltf_near(world.x, expected[v][0]) && gltf_near(world.y, expected[v][1]));
        CHECK(gltf_near(world.z, expected[v][2]));
    }
    gltf_run_end(&run);
}

void test_gltf_morphs_by_default_weights(test_state* test)
{
    const float data[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 2, 0, 0, 3};
    gltf_run run;
    gltf_run_glb(&run,
                 "{" GLTF_ASSET ",'scenes':[{'nodes':[0,1,2]}],"
                 "'nodes':[{'mesh':0},{'mesh':0,'weights':[2]},{'mesh':0}],"
                 "'buffers':[{'byteLength':72}],'bufferViews':[{'buffer':0,'byteLength':72}],"
                 "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'},"
                 "{'bufferView':0,'byteOffset':36,'componentType':5126,'count':3,'type':'VEC3'}],"
                 "'meshes':[{'weights':[0.5],'primitives':[{'attributes':{'POSITION':0},"
                 "'targets':[{'POSITION':1}]}]}]}",
                 data, sizeof(data));
    CHECK_EQUAL(STP_OK, run.result);
    CHECK_EQUAL(2, run.scene->mesh_count); // nodes 0 and 2 share one, node 1 has its own weights
    CHECK(run.scene->meshes[0].positions[8] == 1.5f);
    CHECK(run.scene->meshes[1].positions[8] == 6.0f);
    CHECK_EQUAL(run.scene->parts[run.scene->objects[1].first_part].index,
                run.scene->parts[run.scene->objects[3].first_part].index);
    gltf_run_end(&run);
}

void test_gltf_reads_one_scene_of_many(test_state* test)
{
    gltf_run run;
    gltf_run_glb(&run,
                 "{" GLTF_ASSET ",'scene':1,'scenes':[{'nodes':[0]},{'nodes':[1]}],"
                 "'nodes':[{'name':'a'},{'name':'b'}]}",
                 NULL, 0);
    CHECK_EQUAL(STP_OK, run.result);
    CHECK_EQUAL(2, run.scene->object_count);
    CHECK(strcmp(run.scene->objects[1].name, "b") == 0);
    gltf_run_end(&run);

    // without scenes, all roots are shown
    gltf_run_glb(&run, "{" GLTF_ASSET ",'nodes':[{'name':'a'},{'name':'b'}]}", NULL, 0);
    CHECK_EQUAL(STP_OK, run.result);
    CHECK_EQUAL(3, run.scene->object_count);
    gltf_run_end(&run);
}
