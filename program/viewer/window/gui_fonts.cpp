// SPDX-License-Identifier: MIT
// Fonts of the panels: a fixed set of glyphs, plus those that the shown texts need.
#include "program/viewer/window/gui_internal.h"

extern "C" {
#include "program/viewer/model/glyphs.h"
}

#include <backends/imgui_impl_opengl3.h>
#include <cstdio>
#include <cstring>

namespace
{

SDL_Texture* font_texture;
glyph_set further_glyphs; // in addition to the fixed set
bool font_is_old;         // there are new glyphs

float font_size()
{
    return 15.0f * gui_scale;
}

// Whether a file has a font header: ImGui would abort on any other file.
bool is_font(const char* file)
{
    static const char beginnings[][5] = {{0, 1, 0, 0, 0}, "OTTO", "ttcf", "true"};
    FILE* found = std::fopen(file, "rb");
    char first[4];
    bool read = found != nullptr && std::fread(first, 1, sizeof(first), found) == sizeof(first);
    if (found != nullptr) {
        std::fclose(found);
    }
    bool known = false;
    for (const auto& beginning : beginnings) {
        known = known || (read && std::memcmp(first, beginning, sizeof(first)) == 0);
    }
    return known;
}

// Adds a font, or merges its glyphs into the previous one. @return false if there is no such font
bool add_font(const char* file, const uint16_t* ranges, bool merges)
{
    if (!is_font(file)) {
        return false;
    }
    ImFontConfig config;
    config.MergeMode = merges;
    return ImGui::GetIO().Fonts->AddFontFromFileTTF(file, font_size(), &config, ranges) != nullptr;
}

// A system font with the letters of most European languages, or ImGui's own; and others for names
// in other scripts. A glyph that no font has is shown as a box.
void load_fonts()
{
    static const char* const files[] = {
        "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
        "/usr/share/fonts/truetype/noto/NotoSans-Regular.ttf",
        "/usr/share/fonts/truetype/liberation/LiberationSans-Regular.ttf",
    };
    static const char* const others[] = {
        "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
        "/usr/share/fonts/opentype/noto/NotoSansCJK-Regular.ttc",
        "/usr/share/fonts/truetype/noto/NotoSansCJK-Regular.ttc",
        "/usr/share/fonts/truetype/droid/DroidSansFallbackFull.ttf",
        "/usr/share/fonts/truetype/droid/DroidSansFallback.ttf",
        "/usr/share/fonts/truetype/wqy/wqy-microhei.ttc",
        "/usr/share/fonts/opentype/unifont/unifont.otf",
        "/usr/share/fonts/truetype/unifont/unifont.ttf",
    };
    ImFontAtlas* atlas = ImGui::GetIO().Fonts;
    atlas->Clear();
    bool loaded = false;
    for (const char* file : files) {
        loaded = loaded || add_font(file, glyphs_always, false);
    }
    if (!loaded) {
        ImFontConfig config;
        config.SizePixels = font_size();
        atlas->AddFontDefault(&config);
    }
    if (further_glyphs.count > 0) {
        const uint16_t* ranges = glyphs_make_ranges(&further_glyphs);
        for (const char* file : others) {
            add_font(file, ranges, true);
        }
    }
    atlas->Fonts[0]->FallbackChar = 0x25A1;
}

bool make_font_texture()
{
    unsigned char* pixels;
    int width, height;
    ImGui::GetIO().Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
    font_texture = SDL_CreateTexture(gui_software, SDL_PIXELFORMAT_RGBA32, SDL_TEXTUREACCESS_STATIC,
                                     width, height);
    ImGui::GetIO().Fonts->SetTexID(
        font_texture); // even if it failed, because the old texture is gone
    if (font_texture == nullptr) {
        return false;
    }
    SDL_UpdateTexture(font_texture, nullptr, pixels, 4 * width);
    SDL_SetTextureBlendMode(font_texture, SDL_BLENDMODE_BLEND);
    SDL_SetTextureScaleMode(font_texture, SDL_ScaleModeLinear);
    return true;
}

} // namespace

bool gui_fonts_create()
{
    load_fonts();
    return gui_software == nullptr || make_font_texture();
}

void gui_fonts_destroy()
{
    if (gui_software != nullptr) {
        SDL_DestroyTexture(font_texture);
    }
}

void gui_fonts_rebuild()
{
    if (!font_is_old) {
        return;
    }
    font_is_old = false;
    if (gui_software == nullptr) {
        ImGui_ImplOpenGL3_DestroyFontsTexture();
        load_fonts();
        ImGui_ImplOpenGL3_CreateFontsTexture();
    } else {
        SDL_DestroyTexture(font_texture);
        load_fonts();
        make_font_texture();
    }
}

bool gui_fonts_are_old()
{
    return font_is_old;
}

void gui_need_letters(const char* text)
{
    font_is_old = glyphs_note(&further_glyphs, text) || font_is_old;
}

void gui_need_letters_of(const char* format, va_list list)
{
    char text[2048];
    va_list copy;
    va_copy(copy, list);
    std::vsnprintf(text, sizeof(text), format, copy);
    va_end(copy);
    gui_need_letters(text);
}
