// SPDX-License-Identifier: MIT
//
// Shared by the C++ files that wrap Dear ImGui for C (gui*.cpp).
#pragma once

#include <SDL.h>
#include <cstdarg>
#include <imgui.h>

extern float gui_scale;               // scale of fonts and distances
extern SDL_Renderer* gui_software;    // NULL: OpenGL
const float gui_tooltip_after = 0.5f; // seconds that the mouse rests on something

const ImVec4 gui_accent = {0.30f, 0.62f, 0.82f, 1.0f};

inline ImVec4 gui_mixed(const ImVec4& color, float alpha)
{
    return ImVec4(color.x, color.y, color.z, alpha);
}

// gui_fonts.cpp. Makes the first fonts after ImGui is initialized; false if memory runs out.
bool gui_fonts_create();
void gui_fonts_destroy();
// Called between frames: rebuilds the fonts if texts need more glyphs.
void gui_fonts_rebuild();
bool gui_fonts_are_old();
// Every text from files or users passes through one of these.
void gui_need_letters(const char* text);
void gui_need_letters_of(const char* format, va_list list);
