// SPDX-License-Identifier: MIT
// Recent files and folders of the start page.
#include "tests.h"

#include "program/viewer/model/folder.h"
#include "program/viewer/model/path_list.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static recent_files list;

void test_viewer_recent_files_are_bounded_and_newest_first(test_state* test)
{
    char path[64];
    list = (recent_files){0};
    for (int i = 0; i < 3 * RECENT_MAX; ++i) {
        snprintf(path, sizeof(path), "/models/%d.glb", i);
        recent_add(&list, path);
        CHECK(list.count <= RECENT_MAX && strcmp(list.paths[0], path) == 0);
    }
    CHECK_EQUAL(RECENT_MAX, list.count);
    recent_add(&list, "/models/25.glb"); // opened again: it moves to the front
    CHECK(list.count == RECENT_MAX && strcmp(list.paths[0], "/models/25.glb") == 0);
    CHECK(strcmp(list.paths[1], "/models/29.glb") == 0);
    recent_remove(&list, "/models/29.glb");
    CHECK(list.count == RECENT_MAX - 1 && strcmp(list.paths[1], "/models/28.glb") == 0);
    size_t before = list.count;
    recent_add(&list, "relative.glb");
    recent_add(&list, "/with\nline.glb");
    CHECK_EQUAL(before, list.count);
}

void test_viewer_recent_files_are_kept(test_state* test)
{
    char here[4096], folder_path[4200], file[4300];
    CHECK(getcwd(here, sizeof(here)) != NULL);
    // an absolute path: relative ones in XDG variables are ignored
    snprintf(folder_path, sizeof(folder_path), "%s/stp_recent_%ld", here, (long)getpid());
    setenv("XDG_STATE_HOME", folder_path, 1);
    recent_load(&list); // there is none yet
    CHECK_EQUAL(0, list.count);
    recent_add(&list, "/a/first.glb");
    recent_add(&list, "/b/se cond \xe9.glb");
    recent_save(&list);
    list = (recent_files){0};
    recent_load(&list);
    CHECK(list.count == 2 && strcmp(list.paths[0], "/b/se cond \xe9.glb") == 0);
    CHECK(strcmp(list.paths[1], "/a/first.glb") == 0);
    unsetenv("XDG_STATE_HOME");
    snprintf(file, sizeof(file), "%s/stipple/recent", folder_path);
    CHECK(unlink(file) == 0);
    snprintf(file, sizeof(file), "%s/stipple", folder_path);
    CHECK(rmdir(file) == 0 && rmdir(folder_path) == 0);
}

void test_viewer_recent_files_skip_invalid_paths(test_state* test)
{
    static char text[4 * 65536];
    list = (recent_files){0};
    memset(text, '/', sizeof(text) - 1); // one overlong path
    recent_parse(&list, text);
    CHECK_EQUAL(0, list.count);
    recent_parse(&list, "\n\nnonsense\n/a\n{\"b\": 1}\n/a\n/b");
    CHECK(list.count == 2 && strcmp(list.paths[0], "/a") == 0 && strcmp(list.paths[1], "/b") == 0);
}

static void touch(const char* path)
{
    FILE* file = fopen(path, "wb");
    if (file != NULL) {
        fputs("12345", file);
        fclose(file);
    }
}

void test_viewer_folders_list_folders_then_models(test_state* test)
{
    static const char* const names[] = {"b.GLB", "a.stip", "notes.txt", ".hidden.obj"};
    path_list models = {0};
    char top[64], path[PATH_MAX];
    folder_list f = {0};
    snprintf(top, sizeof(top), "stp_folder_%ld", (long)getpid());
    CHECK(mkdir(top, 0700) == 0);
    snprintf(path, sizeof(path), "%s/Sub", top);
    CHECK(mkdir(path, 0700) == 0);
    for (int i = 0; i < 4; ++i) {
        snprintf(path, sizeof(path), "%s/%s", top, names[i]);
        touch(path);
    }
    CHECK(folder_read(&f, top, false));
    CHECK(f.count == 3 && f.entries[0].is_folder && strcmp(f.entries[0].name, "Sub") == 0);
    CHECK(strcmp(f.entries[1].name, "a.stip") == 0 && f.entries[1].bytes == 5);
    CHECK(strcmp(f.entries[2].name, "b.GLB") == 0);
    CHECK(folder_read(&f, top, true) && f.count == 4);
    CHECK(path_list_expand(&models, top) && models.count == 1); // the models of the folder
    CHECK(strstr(models.paths[0], "/b.GLB") != NULL);
    CHECK(path_list_expand(&models, "missing.obj") && models.count == 2);
    CHECK(strcmp(models.paths[1], "missing.obj") == 0);
    path_list_destroy(&models);
    // an invalid folder leaves the list unchanged
    CHECK(!folder_read(&f, "/nowhere/there", false) && f.count == 4);
    CHECK(folder_join(&f, "Sub", path) && strstr(path, "/Sub") != NULL);
    CHECK(folder_read(&f, path, false) && f.count == 0);
    CHECK(folder_join(&f, "..", path) && folder_read(&f, path, false) && f.count == 3);
    for (int i = 0; i < 4; ++i) {
        snprintf(path, sizeof(path), "%s/%s", top, names[i]);
        unlink(path);
    }
    snprintf(path, sizeof(path), "%s/Sub", top);
    CHECK(rmdir(path) == 0 && rmdir(top) == 0);
    CHECK(folder_read(&f, "/", false) && folder_join(&f, "..", path) && strcmp(path, "/") == 0);
    folder_destroy(&f);
}

void test_viewer_folders_complete_and_filter_names(test_state* test)
{
    char name[64];
    static char names[5][32] = {"Tiles", "tower north.laz", "tower s\u00fcd.laz",
                                "tower s\u00fc\u00df.laz", "Zoo.glb"};
    folder_entry entries[5];
    for (int i = 0; i < 5; ++i) {
        entries[i] = (folder_entry){.name = names[i], .is_folder = i == 0};
    }
    folder_list f = {.entries = entries, .count = 5};
    CHECK(folder_complete(&f, "ti", name, sizeof(name)) && strcmp(name, "Tiles/") == 0);
    CHECK(folder_complete(&f, "TOW", name, sizeof(name)) && strcmp(name, "tower ") == 0);
    CHECK(folder_complete(&f, "tower s", name, sizeof(name)) && strcmp(name, "tower s\u00fc") == 0);
    CHECK(folder_complete(&f, "z", name, sizeof(name)) && strcmp(name, "Zoo.glb") == 0);
    CHECK(folder_complete(&f, "t", name, sizeof(name)) && strcmp(name, "T") == 0);
    CHECK(!folder_complete(&f, "none", name, sizeof(name)));
    CHECK(folder_filter(&entries[1], "NORTH") && folder_filter(&entries[1], ""));
    CHECK(!folder_filter(&entries[1], "south") && !folder_filter(&entries[4], "zoo.glb.laz"));
    char text[1024];
    CHECK(strstr(folder_formats(text, sizeof(text)), ".laz") != NULL &&
          strstr(text, ".e57") != NULL && strstr(text, "wrl") == NULL);
    CHECK(strlen(text) + 1 < sizeof(text)); // all formats
}
