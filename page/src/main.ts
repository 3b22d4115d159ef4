import { mount } from "svelte";
import App from "./App.svelte";
import { chair } from "./chair.svelte";
import { link } from "./link";
import { applyTheme } from "./theme";
import "./theme.css";

applyTheme();
chair.follow(link);
mount(App, { target: document.querySelector("#page")! });
link.connect();
