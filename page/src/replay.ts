import { mount } from "svelte";
import { applyLanguage } from "./i18n/text.svelte";
import Replay from "./Replay.svelte";
import { applyTheme } from "./theme";
import "./theme.css";

applyTheme();
applyLanguage();
mount(Replay, { target: document.querySelector("#page")! });
