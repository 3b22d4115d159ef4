import { mount } from "svelte";
import App from "./App.svelte";
import { chair } from "./chair.svelte";
import { applyLanguage } from "./i18n/text.svelte";
import { link } from "./link";
import { heedLinks, signIn, tokenOfLink } from "./server";
import { applyTheme } from "./theme";
import "./theme.css";

applyTheme();
applyLanguage();
heedLinks(window);
chair.follow(link);
mount(App, { target: document.querySelector("#page")! });
void begin();

/** A link with a token in it, as a QR code carries one, signs in by itself. */
async function begin(): Promise<void> {
  const token = tokenOfLink(window);
  if (token) await signIn(token);
  link.connect();
}
