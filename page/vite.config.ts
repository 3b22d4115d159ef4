import { svelte } from "@sveltejs/vite-plugin-svelte";
import { svelteTesting } from "@testing-library/svelte/vite";
import { defineConfig } from "vitest/config";

const chair = process.env.COHELM_CHAIR ?? "http://127.0.0.1:8000";

export default defineConfig({
  plugins: [svelte(), svelteTesting()],
  build: {
    outDir: "../src/cohelm/web/page",
    emptyOutDir: true,
    target: "es2022",
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    chunkSizeWarningLimit: 650, // kB; the 3-D view with three.js, which no first load contains
    rollupOptions: { input: ["index.html", "therapist.html", "replay.html"] },
  },
  server: {
    proxy: {
      "/api": { target: chair, changeOrigin: true },
      "/ws": { target: chair, ws: true, changeOrigin: true, rewriteWsOrigin: true },
    },
  },
  test: { environment: "jsdom", include: ["src/**/*.test.ts"] },
});
